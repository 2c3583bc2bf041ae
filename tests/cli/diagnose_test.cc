#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

const std::vector<std::string> kHidden{"elbow.gain=25", "elbow.damping=1.4", "elbow.coulomb_friction.Fc=4"};

std::vector<std::string> diagnose(const Arm& arm, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"diagnose",      arm.scenario(), "-o", out.string(),    "--no-engines",
                                "--no-pictures", "--population", "20", "--generations", "5"};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Diagnose, FindsWhatWasHiddenAndWritesItsFiles) {
  const Arm arm(kHidden);
  const fs::path out = arm.folder() / "found";
  const auto record = json_of(lacuna(diagnose(arm, out, {"--json"})));
  EXPECT_EQ(record.at("format"), "lacuna-diagnosis/1");
  EXPECT_EQ(record, json_file(out / "diagnosis.json"));
  EXPECT_EQ(record.at("verdict"), "missing_physics");
  ASSERT_FALSE(record.at("findings").empty());
  EXPECT_EQ(record.at("findings")[0].at("where"), "elbow");
  for (const char* name : {"report.html", "scenario.diagnosed.yaml", "arm.identified.urdf", "test.csv"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  EXPECT_FALSE(fs::exists(out / "checkpoint.json"));
}

TEST(Diagnose, TheDiagnosedScenarioRunsAgain) {
  const Arm arm(kHidden);
  const fs::path out = arm.folder() / "found";
  ASSERT_EQ(lacuna(diagnose(arm, out)).code, 0);
  // The recordings went along: the folder stands for itself.
  const fs::path elsewhere = arm.folder() / "elsewhere";
  fs::rename(out, elsewhere);
  const std::string scenario = (elsewhere / "scenario.diagnosed.yaml").string();
  const Outcome simulated = lacuna({"simulate", scenario, "--recording", "test.csv"});
  EXPECT_EQ(simulated.code, 0) << simulated.err;
  std::ifstream in(arm.folder() / "test.csv");
  const auto measured = columns_of(std::string(std::istreambuf_iterator<char>(in), {})).at("degrees");
  const auto predicted = columns_of(simulated.out).at("degrees");
  ASSERT_EQ(predicted.size(), measured.size());
  for (std::size_t i = 0; i < measured.size(); ++i) EXPECT_NEAR(predicted[i], measured[i], 0.6) << i;
  EXPECT_EQ(lacuna({"export", scenario, "--format", "mjcf"}).code, 0);
  const auto again = json_of(lacuna({"diagnose", scenario, "-o", (elsewhere / "again").string(), "--no-engines",
                                     "--no-pictures", "--population", "20", "--generations", "5", "--json"}));
  EXPECT_TRUE(again.at("findings").empty()) << again.at("findings");
}

TEST(Diagnose, StaysSilentWhereNothingIsMissing) {
  const Arm arm;
  const auto record = json_of(lacuna(diagnose(arm, arm.folder() / "found", {"--json"})));
  EXPECT_EQ(record.at("verdict"), "consistent");
  EXPECT_TRUE(record.at("findings").empty());
}

TEST(Diagnose, ThreadsAndInterruptionsDoNotChangeTheNumbers) {
  const Arm arm(kHidden);
  const fs::path whole = arm.folder() / "whole", parts = arm.folder() / "parts";
  ASSERT_EQ(lacuna(diagnose(arm, whole, {"--threads", "1"})).code, 0);
  std::optional<Outcome> stopped;
  for (int attempt = 0; attempt < 10 && !stopped; ++attempt) {
    fs::remove_all(parts);
    stopped = interrupted_run(diagnose(arm, parts, {"--threads", "2"}), parts / "checkpoint.json");
  }
  ASSERT_TRUE(stopped) << "always done before the signal";
  expect_refused(*stopped, 130, "the same command resumes");
  expect_refused(lacuna(diagnose(arm, parts, {"--seed", "2"})), 2, "checkpoint.json");
  ASSERT_EQ(lacuna(diagnose(arm, parts, {"--threads", "2"})).code, 0);
  EXPECT_EQ(numbers_of(parts / "diagnosis.json"), numbers_of(whole / "diagnosis.json"));
}

TEST(Diagnose, NeverOverwritesWhatItReads) {
  const Arm arm;
  const std::string scenario = arm.files().write("scenario.diagnosed.yaml", kArmScenario).string();
  expect_refused(lacuna({"diagnose", scenario, "-o", arm.folder().string()}), 2, "scenario.diagnosed.yaml");
}

}  // namespace
}  // namespace lacuna::test
