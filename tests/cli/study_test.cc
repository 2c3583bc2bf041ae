#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// A study small enough for a test.
std::vector<std::string> study(const Arm& arm, const fs::path& out, std::vector<std::string> more = {},
                               int generations = 4) {
  std::vector<std::string> line{"study",
                                arm.scenario(),
                                "-o",
                                out.string(),
                                "--population",
                                "14",
                                "--generations",
                                std::to_string(generations),
                                "--seeds",
                                "2"};
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Study, WritesEveryPartAndSaysWhatNeedsATruth) {
  const Arm arm;
  const fs::path out = arm.folder() / "study";
  const auto record = json_of(lacuna(study(arm, out, {"--json"})));
  EXPECT_EQ(record.at("format"), "lacuna-study/1");
  EXPECT_EQ(record, json_file(out / "study.json"));
  const auto& one = record.at("scenarios")[0];
  EXPECT_TRUE(one.at("truth").is_null());
  EXPECT_FALSE(one.at("grid").at("settings").empty());
  EXPECT_EQ(one.at("rivals").at("methods").size(), 7u);
  EXPECT_TRUE(one.at("robustness").at("planted"));
  EXPECT_FALSE(one.at("identifiability").empty());
  EXPECT_FALSE(one.at("engines").empty());
  ASSERT_EQ(one.at("skipped").size(), 1u);
  EXPECT_EQ(one.at("skipped")[0].at("part"), "recovery");
  EXPECT_THAT(one.at("skipped")[0].at("reason").get<std::string>(), HasSubstr("truth is unknown"));
  for (const auto& conclusion : one.at("conclusions"))
    EXPECT_THAT(conclusion.at("claim").get<std::string>(), testing::Not(HasSubstr("parameter")));
  EXPECT_TRUE(fs::exists(out / "report.html"));
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("checkpoint")));
}

TEST(Study, ScoresParametersAgainstATruthFile) {
  const Arm arm;
  std::string truth = kArmScenario.substr(0, kArmScenario.find("recordings:"));
  truth.replace(truth.find("gain: 20, damping: 1"), 20, "gain: 25, damping: 1.4");
  arm.files().write("truth.yaml", truth);
  const auto record =
      json_of(lacuna(study(arm, arm.folder() / "study", {"--json", "--parts", "recovery,identifiability"}, 20)));
  const auto& one = record.at("scenarios")[0];
  EXPECT_EQ(one.at("truth"), nlohmann::json({25.0, 1.4}));
  ASSERT_EQ(one.at("recovery").at("parameters").size(), 2u);
  EXPECT_NEAR(one.at("recovery").at("parameters")[0].at("value")[0], 25.0, 0.05);
  EXPECT_TRUE(one.at("grid").is_null());
  EXPECT_EQ(one.at("skipped").size(), 4u);
}

TEST(Study, GivesTheSameNumbersOnOneAndOnTwoThreadsAndAfterAnInterruption) {
  const Arm arm;
  const std::vector<std::string> grid{"--parts", "grid,rivals"};
  auto on = [&](const char* threads, const char* folder) {
    auto line = study(arm, arm.folder() / folder, grid, 12);
    line.insert(line.end(), {"--threads", threads});
    return line;
  };
  ASSERT_EQ(lacuna(on("1", "one")).code, 0);
  ASSERT_EQ(lacuna(on("2", "two")).code, 0);
  const auto expected = without_clock(json_file(arm.folder() / "one" / "study.json"));
  EXPECT_EQ(expected, without_clock(json_file(arm.folder() / "two" / "study.json")));
  const auto stopped = interrupted_run(on("1", "three"), arm.folder() / "three" / "checkpoint.arm.jsonl");
  if (stopped) {
    EXPECT_EQ(stopped->code, 130);
    EXPECT_THAT(stopped->err, HasSubstr("resumes"));
  }
  ASSERT_EQ(lacuna(on("1", "three")).code, 0);
  EXPECT_EQ(expected, without_clock(json_file(arm.folder() / "three" / "study.json")));
}

TEST(Study, RefusesUnknownPartsAndDoubledNames) {
  const Arm arm;
  expect_refused(lacuna(study(arm, arm.folder() / "a", {"--parts", "grids"})), 2, "grids");
  expect_refused(lacuna({"study", arm.scenario(), arm.scenario(), "-o", (arm.folder() / "b").string()}), 2,
                 "different names");
  expect_refused(lacuna({"study"}), 2, "SCENARIO");
}

}  // namespace
}  // namespace lacuna::test
