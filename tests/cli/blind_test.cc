// `lacuna blind`: verdicts first, labels after; seals; what resumes and what does not stop the others.
#include <fstream>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;

/// Two cases of one arm below `cases`: nothing hidden in b/null, a friction in a_friction.
class Cases {
 public:
  Cases() {
    make("a_friction", {"--effect", "coulomb_friction:elbow", "--visibility", "10"});
    make("b/null", {});
  }
  const fs::path& folder() const { return arm_.folder(); }
  fs::path cases() const { return folder() / "cases"; }
  fs::path out() const { return folder() / "out"; }
  std::vector<std::string> blind(std::vector<std::string> more = {}) const {
    std::vector<std::string> line{"blind", cases().string(), "-o", out().string(), "--no-engines", "--population",
                                  "20",    "--generations",  "5"};
    line.insert(line.end(), more.begin(), more.end());
    return line;
  }

 private:
  void make(const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> line{"conceal",  arm_.scenario(), "-o", (cases() / name).string(),
                                  "--engine", "featherstone"};
    line.insert(line.end(), more.begin(), more.end());
    ASSERT_EQ(lacuna(line).code, 0);
  }
  Arm arm_;
};

TEST(Blind, DiagnosesEveryCaseAndScoresIt) {
  const Cases cases;
  const auto record = json_of(lacuna(cases.blind({"--json"})));
  EXPECT_EQ(record, json_file(cases.out() / "blind.json"));
  ASSERT_EQ(record.at("cases").size(), 2u);
  EXPECT_EQ(record.at("cases")[0].at("case"), "a_friction");
  EXPECT_EQ(record.at("cases")[0].at("seal"), "intact");
  EXPECT_EQ(record.at("cases")[0].at("location_right"), true);
  EXPECT_EQ(record.at("cases")[1].at("case"), "b/null");
  EXPECT_EQ(record.at("cases")[1].at("verdict"), "consistent");
  EXPECT_EQ(record.at("totals").at("null_false_alarms"), 0);
  EXPECT_TRUE(fs::exists(cases.out() / "report.html"));
  EXPECT_EQ(json_file(cases.out() / "b/null/diagnosis.json").at("verdict"), "consistent");
}

TEST(Blind, LabelsDoNotTouchTheVerdicts) {
  const Cases cases;
  // A label that cannot even be read stops the scoring, after every verdict has been given.
  std::ofstream(cases.cases() / "a_friction/label.json") << "no label";
  fs::remove(cases.cases() / "a_friction/label.sha256");
  const Outcome outcome = lacuna(cases.blind());
  expect_refused(outcome, 2, "label.json");
  const std::string verdict = text_of(cases.out() / "a_friction/diagnosis.json");
  EXPECT_NE(verdict, "");
  EXPECT_NE(text_of(cases.out() / "b/null/diagnosis.json"), "");
  EXPECT_FALSE(fs::exists(cases.out() / "blind.json"));
  // Without the label the verdict stands as it was, and is not scored.
  fs::remove(cases.cases() / "a_friction/label.json");
  const auto record = json_of(lacuna(cases.blind({"--json"})));
  EXPECT_TRUE(record.at("cases")[0].at("correct").is_null());
  EXPECT_EQ(record.at("totals").at("labelled"), 1);
  EXPECT_EQ(text_of(cases.out() / "a_friction/diagnosis.json"), verdict) << "made once, to the byte with its time";
}

TEST(Blind, ALabelChangedAfterwardsIsNotScored) {
  const Cases cases;
  std::ofstream(cases.cases() / "a_friction/label.json", std::ios::app) << "\n";
  const Outcome outcome = lacuna(cases.blind({"--json"}));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("seal"), std::string::npos) << outcome.err;
  const auto record = json_file(cases.out() / "blind.json");
  EXPECT_EQ(record.at("cases")[0].at("seal"), "broken");
  EXPECT_TRUE(record.at("cases")[0].at("correct").is_null());
  EXPECT_EQ(record.at("totals").at("labelled"), 1);
}

TEST(Blind, AnInterruptedRunGoesOn) {
  const Cases cases;
  std::optional<Outcome> stopped;
  for (int attempt = 0; attempt < 10 && !stopped; ++attempt) {
    fs::remove_all(cases.out());
    stopped = interrupted_run(cases.blind(), cases.out() / "a_friction/input.txt");
  }
  ASSERT_TRUE(stopped) << "always done before the signal";
  expect_refused(*stopped, 130, "the same command resumes");
  const std::string first = text_of(cases.out() / "a_friction/diagnosis.json");
  EXPECT_FALSE(fs::exists(cases.out() / "blind.json"));
  const auto record = json_of(lacuna(cases.blind({"--json"})));
  EXPECT_EQ(record.at("totals").at("labelled"), 2);
  EXPECT_EQ(text_of(cases.out() / "a_friction/diagnosis.json"), first);
  // Other options are another question.
  json_of(lacuna(cases.blind({"--json", "--seed", "2"})));
  EXPECT_NE(text_of(cases.out() / "a_friction/diagnosis.json"), first);
}

TEST(Blind, ACaseThatFailsDoesNotStopTheOthers) {
  const Cases cases;
  fs::remove(cases.cases() / "a_friction/test.csv");
  const auto record = json_of(lacuna(cases.blind({"--json"})));
  EXPECT_TRUE(record.at("cases")[0].at("verdict").is_null());
  EXPECT_NE(record.at("cases")[0].at("error").get<std::string>().find("test.csv"), std::string::npos);
  EXPECT_EQ(record.at("cases")[0].at("correct"), false);
  EXPECT_EQ(record.at("cases")[1].at("correct"), true);
  EXPECT_EQ(record.at("totals").at("failed"), 1);
}

TEST(Blind, RefusesFoldersWithoutCases) {
  const TemporaryFolder empty;
  expect_refused(lacuna({"blind", empty.path().string()}, empty.path()), 2, "scenario.yaml");
  expect_refused(lacuna({"blind", (empty.path() / "none").string()}, empty.path()), 2, "no folder");
}

}  // namespace
}  // namespace lacuna::test
