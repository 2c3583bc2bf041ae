#include "reports/blind.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/json.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "tests/reports/sample.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

BlindVerdict::Claim claim(const std::string& effect, const std::string& place, double probability = 0.95) {
  return {effect, place, probability, {effect}};
}

BlindCase one_case(std::vector<BlindLabel::Effect> hidden, const std::string& verdict,
                   std::vector<BlindVerdict::Claim> claims = {}) {
  BlindCase out;
  out.name = "case";
  out.label = BlindLabel{std::move(hidden), 2.0};
  out.verdict.emplace();
  out.verdict->verdict = verdict;
  out.verdict->claims = std::move(claims);
  out.verdict->noise = {{"joint_1", 1.0}, {"joint_2", 1.0}};
  out.verdict->train = out.verdict->before = {{"joint_1", 1.0}, {"joint_2", 3.0}};
  out.verdict->after = {{"joint_1", 1.0}, {"joint_2", 2.0}};
  out.verdict->effective_samples = 100.0;
  out.verdict->seconds = 2.0;
  return out;
}

const BlindLabel::Effect kFriction{"coulomb_friction", "joint_2", 25.0}, kDelay{"input_delay", "joint_1", 0.02},
    kRipple{"position_ripple", "joint_1", 6.0};

TEST(BlindScore, NothingHiddenMeansNothingSaid) {
  EXPECT_TRUE(score_case(one_case({}, "consistent")).correct);
  EXPECT_FALSE(score_case(one_case({}, "unknown_physics")).correct);
  const CaseScore alarm = score_case(one_case({}, "missing_physics", {claim("input_delay", "joint_1")}));
  EXPECT_FALSE(alarm.correct);
  EXPECT_EQ(alarm.claim_true, std::vector<bool>{false});
}

TEST(BlindScore, OneEffectNeedsPlaceAndClass) {
  BlindVerdict::Claim rival = claim("stribeck_friction", "joint_2");
  const auto score = [&](const BlindVerdict::Claim& said) {
    return score_case(one_case({kFriction}, "missing_physics", {said}));
  };
  EXPECT_TRUE(score(claim("coulomb_friction", "joint_2")).correct);
  EXPECT_FALSE(score(rival).correct);
  EXPECT_TRUE(score(rival).location);
  rival.members.push_back("coulomb_friction");
  EXPECT_TRUE(score(rival).correct);
  EXPECT_TRUE(score(rival).in_class);
  EXPECT_FALSE(score(rival).effect);
  EXPECT_FALSE(score(claim("coulomb_friction", "joint_1")).location);
  // The right name beside a wrong one is not the right verdict.
  EXPECT_FALSE(score_case(one_case({kFriction}, "missing_physics",
                                   {claim("coulomb_friction", "joint_2"), claim("input_delay", "joint_1")}))
                   .correct);
}

TEST(BlindScore, SeveralEffectsAreComparedAsSets) {
  const auto first = claim("coulomb_friction", "joint_2"), second = claim("input_delay", "joint_1");
  EXPECT_EQ(score_case(one_case({kFriction, kDelay}, "missing_physics", {second, first})).f1, 1.0);
  EXPECT_NEAR(score_case(one_case({kFriction, kDelay}, "missing_physics", {first})).f1, 2.0 / 3.0, 1e-12);
  // One hidden effect cannot make two claims true.
  BlindVerdict::Claim alias = claim("stribeck_friction", "joint_2");
  alias.members.push_back("coulomb_friction");
  EXPECT_EQ(score_case(one_case({kFriction}, "missing_physics", {alias, first})).claim_true,
            (std::vector<bool>{false, true}));
}

TEST(BlindScore, WhatTheCatalogueLacksIsToBeCalledUnknown) {
  EXPECT_TRUE(score_case(one_case({kRipple}, "unknown_physics")).correct);
  EXPECT_EQ(score_case(one_case({kRipple}, "unknown_physics")).kind, CaseKind::outside);
  EXPECT_FALSE(score_case(one_case({kRipple}, "missing_physics", {claim("input_delay", "joint_1")})).correct);
  EXPECT_FALSE(score_case(one_case({kRipple}, "consistent")).correct);
}

TEST(BlindScore, GainIsCountedAgainstAnOracleThatLeavesTheNoise) {
  // Joint 2: 9 before, 4 after, 1 is noise; joint 1 has nothing to gain.
  EXPECT_NEAR(score_case(one_case({kFriction}, "missing_physics")).gain_share, 5.0 / 8.0, 1e-12);
  BlindCase none = one_case({kFriction}, "consistent");
  none.verdict->before = none.verdict->after = none.verdict->noise;
  EXPECT_TRUE(std::isnan(score_case(none).gain_share));
}

TEST(BlindTotals, CountWhatTheirNamesSay) {
  std::vector<BlindCase> cases{one_case({}, "consistent"),
                               one_case({}, "unknown_physics"),
                               one_case({kFriction}, "missing_physics", {claim("coulomb_friction", "joint_2", 0.99)}),
                               one_case({kDelay}, "missing_physics", {claim("coulomb_friction", "joint_2", 0.6)}),
                               one_case({kFriction, kDelay}, "missing_physics", {claim("coulomb_friction", "joint_2")}),
                               one_case({kRipple}, "unknown_physics")};
  cases[2].verdict->first_round = {{"input_delay", "joint_1", 3.0, 1}, {"coulomb_friction", "joint_2", 30.0, 1}};
  cases.push_back(one_case({}, "missing_physics"));
  cases.back().label.reset();  // not scored
  cases.push_back(one_case({}, "missing_physics"));
  cases.back().seal = Seal::broken;  // nor this
  cases.push_back(one_case({kFriction}, ""));
  cases.back().verdict.reset();  // failed: nothing is right
  const BlindTotals t = total(cases);
  EXPECT_EQ(t.cases, 9);
  EXPECT_EQ(t.labelled, 7);
  EXPECT_EQ(t.failed, 1);
  EXPECT_EQ(t.null_false_alarms.hits, 1);
  EXPECT_EQ(t.null_false_alarms.of, 2);
  EXPECT_EQ(t.location_top1.hits, 1);
  EXPECT_EQ(t.location_top1.of, 3);
  EXPECT_EQ(t.abstained_correctly.hits, 1);
  EXPECT_NEAR(t.set_f1, 2.0 / 3.0, 1e-12);
  EXPECT_EQ(t.claims_above_09.hits, 2);
  EXPECT_EQ(t.claims_above_09.of, 2);
  EXPECT_EQ(t.calibration[1].truth.of, 1);
  EXPECT_EQ(t.calibration[1].truth.hits, 0);
  EXPECT_EQ(t.baselines.largest_residual_location.hits, 1);
  EXPECT_EQ(t.baselines.largest_residual_location.of, 2);
  EXPECT_EQ(t.baselines.bic_effect.hits, 1);
  EXPECT_EQ(t.confusion.at("input_delay").at("coulomb_friction, elsewhere"), 1);
  EXPECT_EQ(t.confusion.at("nothing").at("consistent"), 1);
  EXPECT_EQ(t.seconds, 16.0);
}

TEST(Rate, HasTheIntervalOfClopperAndPearson) {
  // Their table: 0 of 60 and 5 of 10, two-sided 95 %.
  const auto none = Rate{0, 60}.ci95();
  EXPECT_EQ(none.first, 0.0);
  EXPECT_NEAR(none.second, 1.0 - std::pow(0.025, 1.0 / 60.0), 1e-9);
  const auto half = Rate{5, 10}.ci95();
  EXPECT_NEAR(half.first, 0.1871, 1e-4);
  EXPECT_NEAR(half.second, 0.8129, 1e-4);
  EXPECT_EQ((Rate{3, 3}.ci95().second), 1.0);
  EXPECT_EQ((Rate{}.ci95()), (std::pair(0.0, 1.0)));
}

TEST(BlindLabels, AreReadAndCheckedInForm) {
  const BlindLabel label = read_label(
      R"({"case": "d03", "effects": [{"effect": "coulomb_friction", "location": "joint_2", "strength": 25}],
          "left_rms_over_noise": 7.2, "truth": {"gain": [1]}})",
      "label.json");
  ASSERT_EQ(label.effects.size(), 1u);
  EXPECT_EQ(label.effects[0].place, "joint_2");
  EXPECT_EQ(label.left_rms_over_noise, 7.2);
  EXPECT_TRUE(std::isnan(read_label(R"({"effects": []})", "label.json").left_rms_over_noise));
  for (const char* bad : {"", "[", "3", "{}", R"({"effects": 3})", R"({"effects": [3]})", R"({"effects": [{}]})",
                          R"({"effects": [{"effect": 1, "location": "a"}]})"})
    EXPECT_NE(test::input_error([&] { read_label(bad, "dir/label.json"); }).find("dir/label.json"), std::string::npos)
        << bad;
}

TEST(BlindVerdicts, AreReadFromADiagnosis) {
  const Diagnosis diagnosis = sample::diagnosis();
  const BlindVerdict verdict = read_verdict(to_json(diagnosis, sample::context()), "diagnosis.json");
  EXPECT_EQ(verdict.verdict, to_string(diagnosis.verdict));
  ASSERT_EQ(verdict.claims.size(), diagnosis.findings.size());
  EXPECT_EQ(verdict.claims[0].members, diagnosis.findings[0].members);
  EXPECT_EQ(verdict.claims[0].probability, diagnosis.findings[0].probability);
  EXPECT_EQ(verdict.noise, diagnosis.noise);
  EXPECT_EQ(verdict.before, rms_in(diagnosis.before, Role::test));
  EXPECT_EQ(verdict.first_round.size(), diagnosis.rounds.at(0).size());
  for (const char* bad : {"", "{}", R"({"format": "lacuna-fit/1"})", R"({"format": "lacuna-diagnosis/1"})"})
    EXPECT_NE(test::input_error([&] { read_verdict(bad, "x.json"); }), "") << bad;
}

TEST(BlindRecord, HasTheNamesThatOthersLookFor) {
  const std::vector<BlindCase> cases{one_case({}, "consistent"),
                                     one_case({kFriction}, "missing_physics", {claim("coulomb_friction", "joint_2")})};
  const auto record = nlohmann::json::parse(to_json(cases, sample::context()));
  EXPECT_EQ(record.at("format"), "lacuna-blind/1");
  EXPECT_TRUE(record.at("context").contains("commit"));
  for (const char* name : {"null_false_alarms", "location_top1", "effect_top1", "class_top1", "abstained_correctly",
                           "set_f1", "heldout_gain_share", "calibration", "seconds"})
    EXPECT_TRUE(record.at("totals").contains(name)) << name;
  EXPECT_EQ(record.at("totals").at("null_false_alarms"), 0);
  EXPECT_EQ(record.at("totals").at("class_top1"), 1.0);
  EXPECT_EQ(record.at("cases")[1].at("label").at("effects")[0].at("location"), "joint_2");
  EXPECT_EQ(record.at("cases")[1].at("correct"), true);
}

TEST(BlindPage, InputCannotBecomeMarkup) {
  const std::string evil = "<script>alert('x')</script>";
  BlindCase hostile = one_case({{evil, evil, 1.0}}, evil, {claim(evil, evil)});
  hostile.name = evil;
  BlindCase failed;
  failed.name = "\xff";
  failed.error = evil;
  const std::string page = blind_page({hostile, failed}, evil, sample::context());
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find('\xff'), std::string::npos);
  for (const char* title : {"Totals", "Confusion", "Calibration", "Baselines", "Cases", "Context"})
    EXPECT_NE(page.find("<h2>" + std::string(title) + "</h2>"), std::string::npos) << title;
  EXPECT_NE(blind_page({}, "", Context{}).find("</html>"), std::string::npos);
  EXPECT_NO_THROW(nlohmann::json::parse(to_json(std::vector<BlindCase>{hostile, failed}, sample::context())));
}

}  // namespace
}  // namespace lacuna
