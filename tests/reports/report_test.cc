#include "reports/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "reports/sections.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "tests/reports/own_scripts.h"
#include "tests/reports/sample.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

class Folder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() / ("lacuna-" + std::string(test->name()) + "-" + std::to_string(::getpid()));
    fs::create_directories(path_);
  }
  void TearDown() override { fs::remove_all(path_); }
  static std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path path_;
};

using WriteReport = Folder;

/// Nothing in the page asks a browser for anything outside it, nor runs, but the library's own scripts.
void expect_self_contained(const std::string& whole) {
  const std::string page = without_own_scripts(whole);
  for (const char* word : {"http://", "https://", "<script", "<link", "<iframe", "<object", "@import", "url(",
                           "src=\"/", "src='", "href=\"/", "href='", " onload", " onerror", "javascript:"})
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  for (std::size_t at = 0; (at = page.find(" src=\"", at)) != std::string::npos; ++at)
    EXPECT_EQ(page.compare(at, 27, " src=\"data:image/png;base64"), 0) << page.substr(at, 60);
  for (std::size_t at = 0; (at = page.find("href=\"", at)) != std::string::npos; ++at) EXPECT_EQ(page[at + 6], '#');
}

TEST(DiagnosisPage, IsSelfContained) {
  const Picture pose{"featherstone", {0x89, 'P', 'N', 'G'}};
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), std::span(&pose, 1));
  expect_self_contained(page);
  EXPECT_NE(page.find("data:image/png;base64,iVBORw=="), std::string::npos);
}

TEST(DiagnosisPage, OpensWithTheVerdict) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  const std::size_t verdict = page.find("Coulomb friction at joint_2 was left out");
  ASSERT_NE(verdict, std::string::npos);
  EXPECT_LT(verdict, page.find("<section"));
}

TEST(DiagnosisPage, DrawsSpeedAgainstCommand) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  const std::size_t section = page.find("Speed against command");
  ASSERT_NE(section, std::string::npos);
  EXPECT_NE(page.find("joint_2: speed against command", section), std::string::npos);
  Diagnosis without = sample::diagnosis();
  without.valves.clear();
  EXPECT_EQ(diagnosis_page(Scenario{}, without, sample::context(), {}).find("Speed against command"),
            std::string::npos);
}

TEST(DiagnosisPage, SaysWhichRecordingsThePValueIsOf) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  EXPECT_NE(page.find("The p-value is of the gains on the train and the validate recordings together"),
            std::string::npos);
}

TEST(DiagnosisPage, SaysNothingRemainsWhereNothingWasRemoved) {
  Diagnosis d = sample::diagnosis();
  d.verdict = Verdict::unknown_physics;
  d.findings.clear();
  d.unexplained = {true, {"joint_3"}, {}, {}, 0.43, 0.0, {}};
  const std::string page = diagnosis_page(Scenario{}, d, sample::context(), {});
  EXPECT_EQ(page.find("remains"), std::string::npos);
  EXPECT_NE(page.find("43 % of the held-out residual energy is more than noise, at joint_3"), std::string::npos);
}

TEST(DiagnosisPage, SaysTheNumberOfEveryRecording) {
  Diagnosis d = sample::diagnosis();
  d.unexplained = {true, {"joint_3"}, {}, {}, 0.43, 0.0, {}, {sample::number_by_recording()}};
  const std::string page = diagnosis_page(Scenario{}, d, sample::context(), {});
  EXPECT_NE(page.find("-0.2 in train_1.csv and +0.3 in validate_1.csv"), std::string::npos);
}

TEST(DiagnosisPage, ANumberThatTheRecordingsDoNotDetermineIsNotPrinted) {
  Diagnosis d = sample::diagnosis();
  d.findings[0].parameters[0] = {"Fc", "N m", 100.0, 0.0, 1513.0, false, false, false, true};
  d.after.estimates[0] = {"joint_2.gain", "N m/V", 1313.7, 0.0, 2e4, false, false, false, true};
  const std::string page = diagnosis_page(Scenario{}, d, sample::context(), {});
  EXPECT_EQ(page.find("1513"), std::string::npos);
  EXPECT_EQ(page.find("1313"), std::string::npos);
  EXPECT_NE(page.find("Fc: not determined"), std::string::npos) << "in the table and in the headline";
}

TEST(DiagnosisPage, HeadlineNamesTheJointsThatGotWorse) {
  Diagnosis d = sample::diagnosis();
  d.worse = {"joint_1", "joint_2"}, d.worse_besides_starts = {"joint_1"};
  const std::string page = diagnosis_page(Scenario{}, d, sample::context(), {});
  EXPECT_NE(page.find("1.01 times the noise. At joint_1 the test residual grew. At joint_2 the test residual grew, but "
                      "by no more than the measured start"),
            std::string::npos);
}

TEST(DiagnosisPage, CountsMissingEffortInTheCommandsUnit) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  for (const char* words : {"0.5 %", "train_1.csv: 0.2 to 0.7 %"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  for (const char* volts : {" V<", " V,", "(V)", "V of command"})
    EXPECT_EQ(page.find(volts), std::string::npos) << volts;
}

TEST(DiagnosisPage, HasEverySection) {
  const Picture pose{"featherstone", {1, 2, 3}};
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), std::span(&pose, 1));
  for (const char* title : {"Findings", "Before and after", "Where the plain model fails", "Residuals",
                            "Whiteness of the residuals", "What was tried", "Parameters", "What the data determine",
                            "Engines", "Pictures", "Population search", "Notes", "Method", "Context"})
    EXPECT_NE(page.find("<h2>" + std::string(title) + "</h2>"), std::string::npos) << title;
}

TEST(DiagnosisPage, DrawsEveryLearnedLawWithWhatItLooksLike) {
  const LearnedLaw ripple = sample::learned_law(), drag = sample::learned_law(false);
  const std::string page = diagnosis_page(Scenario{}, sample::learned_diagnosis({ripple, drag}), sample::context(), {});
  expect_self_contained(page);
  const std::size_t section = page.find("<h2>Learned where the catalogue has no name</h2>");
  ASSERT_NE(section, std::string::npos);
  const std::size_t end = page.find("</section>", section);
  const std::string body = page.substr(section, end - section);
  for (const LearnedLaw* law : {&ripple, &drag}) EXPECT_NE(body.find(law->description + "."), std::string::npos);
  for (const char* words :
       {"<title>Learned effort at joint_2 over the position of joint_2</title>", "position of joint_2, rad",
        "<title>Learned effort at joint_2 over the speed of joint_2</title>", "speed of joint_2, rad/s",
        "Learned effort, ", "94 % of the validate recordings", "a probability of 0.97"})
    EXPECT_NE(body.find(words), std::string::npos) << words;
  // A curve and both edges of its band, each.
  std::size_t paths = 0;
  for (std::size_t at = 0; (at = body.find("<path ", at)) != std::string::npos; ++at) ++paths;
  EXPECT_EQ(paths, 6u);
  EXPECT_NE(page.find("<h2>Before and after</h2>"), std::string::npos) << "a learned law changes the model";
}

TEST(DiagnosisPage, SaysNothingOfLearnedLawsWhereThereAreNone) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  for (const char* words : {"Learned where", "Learned effort at", "Learned from"})
    EXPECT_EQ(page.find(words), std::string::npos) << words;
}

TEST(DiagnosisPage, ALearnedLawsJointIsTextAndNoMarkup) {
  LearnedLaw law = sample::learned_law();
  law.place = "<script>alert(1)</script>";
  describe_curve(law);
  const std::string page = diagnosis_page(Scenario{}, sample::learned_diagnosis({law}), sample::context(), {});
  expect_self_contained(page);
  EXPECT_NE(page.find("<h3>Learned effort at &lt;script&gt;alert(1)&lt;/script&gt;</h3>"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(1)&lt;/script&gt; lacks a torque"), std::string::npos);
}

TEST(DiagnosisPage, AnEventsNamesAreTextAndNoMarkup) {
  LearnedEvent event = sample::learned_event();
  event.place = "<script>alert(1)</script>", event.recording = "<script>alert(2)</script>.csv";
  const std::string page = diagnosis_page(Scenario{}, sample::eventful_diagnosis({event}), sample::context(), {});
  expect_self_contained(page);
  EXPECT_NE(page.find("Events at &lt;script&gt;alert(1)&lt;/script&gt;: a push of 12 N m in "
                      "&lt;script&gt;alert(2)&lt;/script&gt;.csv from 6.1 to 6.6 s"),
            std::string::npos);
}

TEST(DiagnosisPage, InputCannotBecomeMarkup) {
  Context context = sample::context();
  context.command_line = "<script>alert(1)</script>";
  const Picture pose{"\"><script>alert(2)</script>", {1, 2, 3}};
  const std::string page = diagnosis_page(Scenario{}, sample::hostile_diagnosis(), context, std::span(&pose, 1));
  expect_self_contained(page);
  EXPECT_EQ(without_own_scripts(page).find("alert('"), std::string::npos);
  EXPECT_EQ(page.find('\xff'), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"), std::string::npos);
}

TEST(DiagnosisPage, OfNothingIsStillAPage) {
  expect_self_contained(diagnosis_page(Scenario{}, Diagnosis{}, Context{}, {}));
}

TEST(DiagnosisPage, CarriesEachScriptOnceWithItsHashInThePolicy) {
  const std::string page = diagnosis_page(Scenario{}, sample::diagnosis(), sample::context(), {});
  const std::string own = "<script>" + std::string(kPageScripts) + "</script>";
  ASSERT_NE(page.find(own), std::string::npos);
  EXPECT_EQ(page.find(own, page.find(own) + 1), std::string::npos);
  const std::size_t policy = page.find("script-src"), end = page.find(';', policy);
  const std::string sources = page.substr(policy, end - policy);
  EXPECT_EQ(sources.find("unsafe"), std::string::npos);
  EXPECT_EQ(std::count(sources.begin(), sources.end(), '\''), kPlotLibrary.empty() ? 2 : 4);
  EXPECT_EQ(page.find("MIT-licenced") != std::string::npos, !kPlotLibrary.empty());
}

TEST(DiagnosisPage, WithoutPlotsHasNoScripts) {
  const std::string page = diagnosis_page(Scenario{}, Diagnosis{}, Context{}, {});
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("script-src 'none'"), std::string::npos);
}

TEST(FitPage, ComparesEngines) {
  std::vector<FitResult> fits{sample::fit(1e-3), sample::fit(2e-3)};
  fits[1].engine = "mujoco";
  fits[1].estimates.pop_back();
  const std::vector<Trace> traces{sample::trace("joint_2")};
  const std::string page = fit_page(Scenario{}, fits, sample::context(), {}, traces);
  expect_self_contained(page);
  EXPECT_NE(page.find("Engines side by side"), std::string::npos);
  expect_self_contained(fit_page(Scenario{}, {}, Context{}, {}));
}

TEST_F(WriteReport, WritesPageAndRecord) {
  EXPECT_EQ(
      write_diagnosis_report(path_ / "new" / "folder", Scenario{}, sample::diagnosis(), sample::context(), {}).size(),
      2u);
  EXPECT_EQ(nlohmann::json::parse(read(path_ / "new/folder/diagnosis.json"))["format"], "lacuna-diagnosis/1");
  EXPECT_TRUE(read(path_ / "new/folder/report.html").starts_with("<!DOCTYPE html>"));
  write_fit_report(path_, Scenario{}, sample::fit(1e-3), sample::context(), {});
  EXPECT_EQ(nlohmann::json::parse(read(path_ / "fit.json"))["format"], "lacuna-fit/1");
}

TEST_F(WriteReport, LeavesNoUnfinishedFilesBehind) {
  write_fit_report(path_, Scenario{}, sample::fit(1e-3), sample::context(), {});
  EXPECT_EQ(std::distance(fs::directory_iterator(path_), fs::directory_iterator()), 2);
}

TEST_F(WriteReport, FailureIsAWriteError) {
  std::ofstream(path_ / "file") << "not a folder";
  EXPECT_THROW(write_fit_report(path_ / "file", Scenario{}, sample::fit(1e-3), sample::context(), {}), WriteError);
}

TEST_F(WriteReport, FailureLeavesTheOldFile) {
  // The longest name a file can have leaves no room for the neighbour that is written first.
  const fs::path file = path_ / std::string(255, 'r');
  std::ofstream(file) << "old";
  EXPECT_THROW(write_file_atomically(file, "new"), WriteError);
  EXPECT_EQ(read(file), "old");
}

TEST(ChainSection, DrawsWhatFailsAndWhatCannotBeJudgedUnderAnyName) {
  JointChain chain{"<b>&\"", true, {}};
  for (std::size_t k = 0; k < chain.parts.size(); ++k) {
    PartFit& part = chain.parts[k];
    part = {kParts[k], "", "rad/s", 100.0, 1.0, 0.1, 0.1, 0.1, 0.1, 0.1, 1.0, 1.0};
  }
  chain.parts[0].before = 1.2, chain.parts[0].p_before = 1e-9;
  chain.parts[1].why_not = "no <other> joint";
  const std::string page = chain_section(std::vector{chain, chain}, true).markup;
  EXPECT_THAT(page, testing::HasSubstr(
                        "The plain model fails at: command to flow (12 times the noise, 1 with what was found)"));
  EXPECT_THAT(page, testing::HasSubstr("Not judged: supply (no &lt;other&gt; joint)"));
  EXPECT_THAT(page, testing::HasSubstr("&lt;b&gt;&amp;&quot;"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("<b>")));
  EXPECT_EQ(page.find("<marker"), page.rfind("<marker")) << "one of each id in a page";
  EXPECT_EQ(chain_section({}, true).markup, "");
}

}  // namespace
}  // namespace lacuna
