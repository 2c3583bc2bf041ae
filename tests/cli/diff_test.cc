#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::vector<std::string> diff(const std::string& a, const std::string& b, const fs::path& out,
                              std::vector<std::string> more = {}) {
  std::vector<std::string> line{"diff", a, b, "-o", out.string(), "--population", "20", "--generations", "5"};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(DiffCommand, NamesTheGainThatChangedAndWritesItsFiles) {
  const Arm before, after({"elbow.gain=27", "elbow.damping=1.4"});
  const fs::path out = before.folder() / "changed";
  const auto record = json_of(lacuna(diff(before.scenario(), after.scenario(), out, {"--json"})));
  EXPECT_EQ(record, json_file(out / "diff.json"));
  EXPECT_EQ(record.at("verdict"), "changed");
  ASSERT_EQ(record.at("changes").size(), 1u) << record.at("changes");
  EXPECT_EQ(record.at("changes")[0].at("parameter"), "gain");
  EXPECT_EQ(record.at("changes")[0].at("where"), "elbow");
  for (const char* name : {"report.html", "a/diagnosis.json", "b/diagnosis.json", "b/report.html"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  EXPECT_FALSE(fs::exists(out / "a" / "checkpoint.json"));
}

TEST(DiffCommand, TakesRecordingsWithAnotherScenariosModel) {
  const Arm arm;
  const auto file = [&](const char* name) { return (arm.folder() / name).string(); };
  fs::create_directories(arm.folder() / "second");
  for (const char* name : {"train.csv", "validate.csv", "test.csv"})
    fs::copy_file(arm.folder() / name, arm.folder() / "second" / name);
  arm.files().write("list.txt", "# of the first\ntrain.csv\n\ntest.csv\n");
  const fs::path out = arm.folder() / "same";
  const std::vector<std::string> model{"--scenario", arm.scenario(), "--json"};
  for (const std::string& a : {file("train.csv"), file("list.txt"), file("train.csv") + "," + file("validate.csv")}) {
    const auto record = json_of(lacuna(diff(a, file("second"), out, model)));
    EXPECT_EQ(record.at("verdict"), "same") << a;
    EXPECT_TRUE(record.at("a").at("fit").contains("test")) << a;
  }
}

TEST(DiffCommand, RefusesWhatCannotBeComparedInOneLine) {
  const Arm arm;
  const fs::path out = arm.folder() / "out";
  const std::string other =
      arm.files().write("other.yaml", replaced(kArmScenario, "stiffness: 30", "stiffness: 31")).string();
  expect_refused(lacuna(diff(arm.scenario(), other, out)), kBadInput,
                 "other.yaml: actuators.elbow.stiffness: found 31, expected 30");
  expect_refused(lacuna(diff(arm.scenario(), "none.yaml", out)), kBadInput, "none.yaml");
  const std::string train = (arm.folder() / "train.csv").string();
  const auto with_model = [&](const std::string& a) {
    return lacuna(diff(a, train, out, {"--scenario", arm.scenario()}));
  };
  expect_refused(with_model("none.csv"), kBadInput, "A: found no file");
  expect_refused(with_model(arm.scenario()), kBadInput, "with --scenario a folder");
  expect_refused(with_model(train + "," + train), kBadInput, "twice");
  const std::string spoiled = arm.files().write("spoiled.csv", "t,u\n0,1\n0.1,1\n").string();
  expect_refused(with_model(spoiled), kBadInput, "degrees");
  expect_refused(lacuna({"diff", arm.scenario()}), kBadInput, "B");
}

TEST(DiffCommand, FindsTheLoadThatARealArmCarries) {
  // A UR10e's motion without and with 2.805 kg at the flange; its links' masses are free, and each set is one
  // recording.
  const auto data = shared_data();
  const fs::path folder = data ? *data / "recordings" / "ur10e" : fs::path();
  if (!data || !fs::exists(folder / "l14.csv")) GTEST_SKIP() << "no shared recordings of the UR10e";
  const TemporaryFolder out;
  const auto record =
      json_of(lacuna({"diff", (folder / "u14.csv").string(), (folder / "l14.csv").string(), "--scenario",
                      (folder / "scenario.yaml").string(), "-o", out.path().string(), "--json"}));
  ASSERT_EQ(record.at("changes").size(), 1u) << record.at("changes");
  const auto& load = record.at("changes")[0];
  EXPECT_EQ(load.at("name"), "arm.payload");
  EXPECT_GT(load.at("probability"), 0.9);
  EXPECT_LE(load.at("b").at("ci95")[0], 2.805);
  EXPECT_GE(load.at("b").at("ci95")[1], 2.805);
  const auto& test = record.at("b").at("fit").at("test");
  for (const auto& [joint, rms] : test.at("shared_and_changed").items())
    EXPECT_LT(rms, test.at("model_a").at(joint)) << joint;
}

TEST(DiffCommand, ResumesToTheSameNumbers) {
  const Arm before({"elbow.gain=25", "elbow.damping=1.4", "elbow.coulomb_friction.Fc=4"}),
      after({"elbow.gain=25", "elbow.damping=1.4", "elbow.coulomb_friction.Fc=5"});
  const fs::path whole = before.folder() / "whole", parts = before.folder() / "parts";
  ASSERT_EQ(lacuna(diff(before.scenario(), after.scenario(), whole, {"--threads", "1"})).code, 0);
  std::optional<Outcome> stopped;
  for (int attempt = 0; attempt < 10 && !stopped; ++attempt) {
    fs::remove_all(parts);
    stopped = interrupted_run(diff(before.scenario(), after.scenario(), parts), parts / "b" / "checkpoint.json");
  }
  ASSERT_TRUE(stopped) << "always done before the signal";
  expect_refused(*stopped, 130, "the same command resumes");
  ASSERT_EQ(lacuna(diff(before.scenario(), after.scenario(), parts)).code, 0);
  EXPECT_EQ(numbers_of(parts / "diff.json"), numbers_of(whole / "diff.json"));
}

}  // namespace
}  // namespace lacuna::test
