#include "reports/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/reports/own_scripts.h"

namespace lacuna {
namespace {

using testing::HasSubstr;
using testing::Not;

SettingRecord setting(const std::string& key, const std::string& title, Fitness fitness) {
  SettingRecord out{key, key.substr(0, key.find('.')), title, {}, fitness, {}};
  for (int k = 0; k < 3; ++k) {
    SearchRun run;
    run.point = {10.0 + k, 2.0};
    run.cost = 1.0 + 0.1 * k;
    run.evaluations = 100;
    run.curve = {{50, 3.0}, {100, run.cost}};
    run.errors = {0.5, 0.1, 42.0, std::nan("")};
    out.runs.push_back(run);
  }
  return out;
}

/// A study of every part, its names hostile.
Study sample_study() {
  Study out;
  out.scenario = "<script>alert(1)</script>";
  out.parameters = {"a<b", "c&d"};
  out.units = {"N m/V", "kg"};
  out.start = {1.0, 2.0};
  out.lower = {0.0, 0.0};
  out.upper = {20.0, 20.0};
  out.truth = {10.0, 2.0};
  out.output_unit = "deg";
  out.seeds = 3;
  out.grid.settings = {setting("final", "final", Fitness::norm_inf),
                       setting("coding.integer", "integer", Fitness::norm_inf)};
  out.grid.rankings = {{"norm_inf", 500, 0, 3, 3}};
  out.grid.output = {"train.csv", "deg", {0.0, 1.0, 2.0}, {0.0, 5.0, std::nan("")}, {0.0, 4.0, 3.0}, 0.5, 2};
  out.engines = {{"featherstone", "", setting("final", "final", Fitness::norm_inf)},
                 {"ode", "not built <here>", setting("final", "final", Fitness::norm_inf)}};
  out.engines[1].setting.runs.clear();
  Excitation excitation;
  excitation.name = "train.csv";
  excitation.rank = 1;
  excitation.parameters = 2;
  excitation.condition = HUGE_VAL;
  excitation.knowledge = {{"a<b", "N m/V", 10.0, 0.01, true}, {"c&d", "kg", 2.0, 5e5, false}};
  excitation.undetermined = {"1.00 c&d"};
  excitation.ellipses = {{"a<b", "c&d", "N m/V", "kg", 10.0, 2.0, {9.0, 11.0, 9.0}, {1.0, 3.0, 1.0}}};
  out.identifiability = {excitation};
  out.rivals.budget = 14000;
  out.rivals.best = 1.0;
  for (const SearchMethod method : all_methods())
    out.rivals.methods.push_back({method,
                                  setting("x", "x", Fitness::norm_2).runs,
                                  {{50.0, HUGE_VAL, 70.0}, {50.0, 60.0, 70.0}, {5.0, 6.0, 7.0}},
                                  {2.0 / 3.0, 1.0, 1.0}});
  out.rivals.recommended = 1;
  out.rivals.reason = "CMA-ES is recommended here.";
  for (const Searcher searcher : all_searchers())
    out.robustness.cells.push_back(
        {robustness_conditions().front(), searcher, setting("x", "x", Fitness::norm_2).runs});
  out.recovery = {{{"a<b", "N m/V", 10.0, {10.1, 9.9}, {9.8, 9.7}, {10.3, 9.95}, {true, true}}}, 1, 2};
  out.conclusions = {{"fig. 3", "MVBS is better", "a test", "1.0 against 1.1", Judgement::cannot_be_told}};
  out.skipped = {{"none", "of them"}};
  return out;
}

TEST(StudyPage, CarriesEveryPartAndEscapesWhatComesFromInput) {
  const Study study = sample_study();
  const std::string page = without_own_scripts(study_page(std::span(&study, 1), make_context(1, 2, "lacuna study")));
  EXPECT_THAT(page, Not(HasSubstr("<script>")));
  EXPECT_THAT(page, Not(HasSubstr("a<b")));
  EXPECT_THAT(page, Not(HasSubstr("<here>")));
  for (const char* words :
       {"cannot be told", "Figure 3", "Figure 8", "Table 3", "0.645", "327", "within twice the best",
        "CMA-ES is recommended", "no noise", "1 of 2", "moves nothing", "MVBS is better", "of them"})
    EXPECT_THAT(page, HasSubstr(words));
  EXPECT_THAT(page, Not(HasSubstr(">nan<")));
  EXPECT_THAT(page, Not(HasSubstr(">inf<")));
}

TEST(StudyPage, HoldsNoSectionsOfWhatWasLeftOut) {
  Study study;
  study.scenario = "bare";
  const std::string page = study_page(std::span(&study, 1), make_context(1, 1, "lacuna study"));
  EXPECT_THAT(page, Not(HasSubstr("Figure 3")));
  EXPECT_THAT(page, HasSubstr("bare"));
}

TEST(StudyRecord, HoldsFiniteNumbersOrNull) {
  const Study study = sample_study();
  const auto record = nlohmann::json::parse(to_json(std::span(&study, 1), make_context(3, 2, "lacuna study")));
  EXPECT_EQ(record.at("format"), "lacuna-study/1");
  const auto& one = record.at("scenarios")[0];
  EXPECT_EQ(one.at("grid").at("settings")[0].at("cost").at("median"), 1.1);
  EXPECT_TRUE(one.at("grid").at("settings")[0].at("combination_error_index").at("median").is_null());
  EXPECT_TRUE(one.at("identifiability")[0].at("condition").is_null());
  EXPECT_TRUE(one.at("rivals").at("methods")[0].at("evaluations_to_level")[0][1].is_null());
  EXPECT_EQ(one.at("rivals").at("recommended"), "cmaes");
  EXPECT_EQ(record.at("paper").at("fitness")[0].at("output_error_index"), 0.645);
}

DesignResult designed() {
  DesignResult out;
  for (Design* d : {&out.best, &out.step}) {
    d->name = "<b>both</b>";
    d->commands = {{0.0, 0.1, 0.2}, {{0.0, 1.0, 0.0}}};
    d->log_det = d == &out.best ? 12.0 : 3.0;
    d->excitation = sample_study().identifiability.front();
    d->peak_command = {1.0};
    d->peak_speed = d->lowest = d->highest = {0.5};
  }
  return out;
}

TEST(ExcitationPage, ShowsCommandsAndEscapes) {
  const std::string page = excitation_page(designed(), "arm", {"elbow<"}, {"%"}, make_context(1, 1, "lacuna excite"));
  EXPECT_THAT(page, Not(HasSubstr("<b>both")));
  EXPECT_THAT(page, Not(HasSubstr("elbow<<")));
  EXPECT_THAT(page, HasSubstr("Expected standard errors"));
  EXPECT_THAT(page, HasSubstr("<svg"));
}

TEST(ExcitationRecord, IsWhatItSays) {
  const auto record = nlohmann::json::parse(to_json(designed(), "arm", "x.csv", make_context(1, 1, "lacuna excite")));
  EXPECT_EQ(record.at("best").at("log_det"), 12.0);
  EXPECT_EQ(record.at("commands"), "x.csv");
}

}  // namespace
}  // namespace lacuna
