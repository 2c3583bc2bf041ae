#include "render/snapshot.h"
#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::vector<std::string> identify(const Arm& arm, const fs::path& out, std::vector<std::string> more = {},
                                  int generations = 10) {
  std::vector<std::string> line{"identify",      arm.scenario(),  "-o",
                                out.string(),    "--population",  "20",
                                "--no-pictures", "--generations", std::to_string(generations)};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Identify, FindsTheTruthAndWritesItsFiles) {
  const Arm arm;
  const fs::path out = arm.folder() / "fit";
  const auto record = json_of(lacuna(identify(arm, out, {"--json"})));
  EXPECT_EQ(record.at("format"), "lacuna-fit/1");
  EXPECT_EQ(record, json_file(out / "fit.json"));
  const auto& parameters = record.at("engines")[0].at("parameters");
  EXPECT_NEAR(parameters.at("elbow.gain").at("value"), 25.0, 0.05);
  EXPECT_NEAR(parameters.at("elbow.damping").at("value"), 1.4, 0.05);
  for (const char* name : {"report.html", "arm.identified.urdf", "scenario.identified.yaml", "train.csv"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  EXPECT_FALSE(fs::exists(out / "checkpoint.json"));
  EXPECT_THAT(record.at("context").at("command_line").get<std::string>(), HasSubstr("identify"));
}

TEST(Identify, TheIdentifiedScenarioRunsAgain) {
  const Arm arm;
  const fs::path out = arm.folder() / "fit";
  ASSERT_EQ(lacuna(identify(arm, out)).code, 0);
  const std::string scenario = (out / "scenario.identified.yaml").string();
  const Outcome again = lacuna({"simulate", scenario});
  const auto gain = json_file(out / "fit.json").at("engines")[0].at("parameters").at("elbow.gain").at("value");
  const auto damping = json_file(out / "fit.json").at("engines")[0].at("parameters").at("elbow.damping").at("value");
  const Outcome direct = lacuna(
      {"simulate", arm.scenario(), "--set", "elbow.gain=" + gain.dump(), "--set", "elbow.damping=" + damping.dump()});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(again.out, direct.out);
  // With pictures, where they can be drawn.
  EXPECT_EQ(lacuna({"identify", scenario, "--optimizer", "lsq", "-o", (out / "again").string()}).code, 0);
  EXPECT_EQ(fs::exists(out / "again" / "pose_featherstone.png"), render_available());
}

TEST(Identify, ThreadsDoNotChangeTheNumbers) {
  const Arm arm;
  ASSERT_EQ(lacuna(identify(arm, arm.folder() / "one", {"--threads", "1"})).code, 0);
  ASSERT_EQ(lacuna(identify(arm, arm.folder() / "two", {"--threads", "2"})).code, 0);
  EXPECT_EQ(numbers_of(arm.folder() / "one" / "fit.json"), numbers_of(arm.folder() / "two" / "fit.json"));
}

TEST(Identify, OneRecordPerEngine) {
  const Arm arm;
  std::size_t available = 0;
  for (const auto& engine : engine_records()) available += engine.at("available").get<bool>() ? 1 : 0;
  const auto record = json_of(lacuna(identify(arm, arm.folder() / "all", {"--engine", "all", "--json"})));
  ASSERT_EQ(record.at("engines").size(), available);
  for (const auto& engine : record.at("engines"))
    EXPECT_NEAR(engine.at("parameters").at("elbow.gain").at("value"), 25.0, 0.05) << engine.at("engine");
}

TEST(Identify, InterruptedItResumesToTheSameNumbers) {
  const Arm arm;
  const fs::path whole = arm.folder() / "whole", parts = arm.folder() / "parts";
  constexpr int kGenerations = 150;
  ASSERT_EQ(lacuna(identify(arm, whole, {}, kGenerations)).code, 0);
  std::optional<Outcome> stopped;
  for (int attempt = 0; attempt < 10 && !stopped; ++attempt) {
    fs::remove_all(parts);
    stopped = interrupted_run(identify(arm, parts, {}, kGenerations), parts / "checkpoint.json");
  }
  ASSERT_TRUE(stopped) << "always done before the signal";
  expect_refused(*stopped, 130, "the same command resumes");
  EXPECT_FALSE(fs::exists(parts / "fit.json"));
  // Another command is not taken for the same.
  expect_refused(lacuna(identify(arm, parts, {"--seed", "2"}, kGenerations)), 2, "checkpoint.json");
  ASSERT_EQ(lacuna(identify(arm, parts, {}, kGenerations)).code, 0);
  EXPECT_FALSE(fs::exists(parts / "checkpoint.json"));
  EXPECT_EQ(numbers_of(parts / "fit.json"), numbers_of(whole / "fit.json"));
}

TEST(Identify, WithoutFreeParametersThereIsNothingToDo) {
  const Arm arm;
  const std::string text = replaced(replaced(kArmScenario, "identify:\n  gain: {relative_bounds: [0.25, 4]}\n", ""),
                                    "  damping: {relative_bounds: [0.25, 4]}\n", "");
  const std::string scenario = arm.files().write("fixed.yaml", text).string();
  expect_refused(lacuna({"identify", scenario}), 2, "identify");
}

}  // namespace
}  // namespace lacuna::test
