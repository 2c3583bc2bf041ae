#include "trial/score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "reports/blind.h"
#include "tests/reports/sample.h"
#include "tests/trial/cases.h"

namespace lacuna {
namespace {

using test::claim;
using test::kDelay;
using test::kFriction;
using test::kRipple;
using test::one_case;

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

/// A curve over x from -1 to 1 at the link, by its values.
template <class Value>
LawRecord law(const Value& value, int points = 41) {
  LawRecord out{"link", {"q"}, {}, {}};
  for (int k = 0; k < points; ++k) {
    const double x = -1.0 + 2.0 * k / (points - 1);
    out.curve.push_back({{x}, value(x)});
  }
  return out;
}
LawRecord happened(const std::string& stage, std::vector<LawRecord::Event> events) {
  return {stage, {"t"}, {}, std::move(events)};
}
double wave(double x) { return 2.0 * std::sin(6.0 * x); }

BlindCase learned_case(const BlindLabel::Effect& hidden, std::vector<LearnedRecord> learned) {
  BlindCase out = one_case({hidden}, "unknown_physics");
  out.verdict->learned = std::move(learned);
  return out;
}

BlindCase under(const std::string& condition, BlindCase one) {
  one.label->conditions[condition] = 0.5;
  return one;
}

TEST(BlindConditions, AMachineUnlikeAnyModelMayBeCalledUnknownButNothingFalseBeClaimed) {
  for (const char* verdict : {"consistent", "unknown_physics"})
    EXPECT_TRUE(score_case(under("background", one_case({}, verdict))).correct) << verdict;
  EXPECT_FALSE(
      score_case(under("background", one_case({}, "missing_physics", {claim("input_delay", "joint_1")}))).correct);
  const std::vector<BlindVerdict::Claim> right{claim("coulomb_friction", "joint_2")};
  EXPECT_TRUE(score_case(under("background", one_case({kFriction}, "unknown_physics", right))).correct);
  EXPECT_FALSE(score_case(one_case({kFriction}, "unknown_physics", right)).correct);
  EXPECT_FALSE(score_case(under("background", one_case({kFriction}, "unknown_physics"))).correct)
      << "what was hidden is to be claimed all the same";
  // How a joint is driven excuses nothing.
  EXPECT_FALSE(score_case(under("alone", one_case({}, "unknown_physics"))).correct);
}

TEST(BlindConditions, AnotherLawOfTheSameStageDescribesWhatIsUneven) {
  const std::vector<BlindVerdict::Claim> both{claim("coulomb_friction", "joint_2"),
                                              claim("hysteresis_friction", "joint_2")};
  const auto score = [&](const std::string& condition, const std::vector<BlindVerdict::Claim>& claims) {
    return score_case(under(condition, one_case({kFriction}, "missing_physics", claims)));
  };
  for (const char* condition : {"uneven", "drift"}) {
    EXPECT_TRUE(score(condition, both).correct) << condition;
    EXPECT_EQ(score(condition, both).claim_true, (std::vector<bool>{true, true}));
    EXPECT_FALSE(score(condition, {both[0], claim("hysteresis_friction", "joint_1")}).correct) << "elsewhere";
    EXPECT_FALSE(score(condition, {both[0], claim("valve_deadband", "joint_2")}).correct) << "another stage";
    EXPECT_FALSE(score(condition, {both[1]}).correct) << "the law itself is missing";
  }
  EXPECT_FALSE(score("background", both).correct);
  EXPECT_TRUE(score("misplaced", {both[0], claim("com_shift", "joint_1")}).correct);
  EXPECT_FALSE(score("misplaced", {both[0], claim("payload", "arm")}).correct);
  EXPECT_TRUE(score("misplaced", {claim("com_shift", "joint_1"), both[0]}).in_class) << "the first that is asked for";
}

TEST(BlindConditions, EachIsCountedApart) {
  const std::vector<BlindVerdict::Claim> right{claim("coulomb_friction", "joint_2")};
  std::vector<BlindCase> cases{one_case({}, "consistent"), one_case({kFriction}, "missing_physics", right)};
  EXPECT_TRUE(totals_by_condition(cases).empty());
  cases.push_back(under("background", one_case({}, "missing_physics", right)));
  cases.push_back(under("alone", under("background", one_case({kFriction}, "missing_physics", right))));
  std::vector<BlindLabel::Effect> everywhere;
  for (const char* joint : {"joint_1", "joint_2", "joint_3"}) everywhere.push_back({"coulomb_friction", joint, 1.0});
  cases.push_back(one_case(everywhere, "missing_physics", right));
  std::map<std::string, BlindTotals> by;
  for (const auto& [name, totals] : totals_by_condition(cases)) by[name] = totals;
  ASSERT_EQ(by.size(), 4u);
  EXPECT_EQ(by["background"].cases, 2);
  EXPECT_EQ(by["background"].null_false_alarms.hits, 1);
  EXPECT_EQ(by["background"].class_top1.hits, 1);
  EXPECT_EQ(by["alone"].cases, 1);
  EXPECT_EQ(by["everywhere"].cases, 1);
  EXPECT_NEAR(by["everywhere"].set_f1, 0.5, 1e-12);
  EXPECT_EQ(by["none"].cases, 2);
}

TEST(BlindLaws, PlaceStageAndVariablesCountTogether) {
  BlindLabel::Effect hidden = kRipple;
  hidden.law = law(wave);
  const auto score = [&](const std::string& place, const std::string& stage, const std::string& over) {
    LawRecord said = law(wave);
    said.stage = stage;
    said.over = {over};
    return score_case(learned_case(hidden, {{"joint_3", law(wave)}, {place, said}})).laws.at(0);
  };
  const LawScore right = score("joint_1", "link", "q");
  EXPECT_TRUE(right.place && right.stage && right.over);
  EXPECT_NEAR(right.curve_error, 0.0, 1e-12);
  const LawScore variable = score("joint_1", "link", "v"), stage = score("joint_1", "command", "q"),
                 place = score("joint_2", "link", "q");
  EXPECT_TRUE(variable.place && variable.stage && !variable.over);
  EXPECT_TRUE(stage.place && !stage.stage && !stage.over);
  EXPECT_FALSE(place.place || place.stage || place.over);
  for (const LawScore& wrong : {variable, stage, place}) EXPECT_TRUE(std::isnan(wrong.curve_error));
  hidden.law.reset();  // as in labels of earlier versions
  EXPECT_TRUE(score("joint_1", "link", "q").place);
  EXPECT_FALSE(score("joint_1", "link", "q").stage);
}

TEST(BlindLaws, ACurveIsComparedBeyondItsLine) {
  const LawRecord hidden = law(wave);
  EXPECT_NEAR(curve_error(hidden, law([](double x) { return wave(x) + 7.0 - 3.0 * x; })), 0.0, 1e-12);
  EXPECT_NEAR(curve_error(hidden, law([](double x) { return 0.5 * wave(x); })), 0.5, 1e-12);
  EXPECT_NEAR(curve_error(hidden, law([](double) { return 1.0; })), 1.0, 1e-12);
  EXPECT_NEAR(curve_error(hidden, law([](double x) { return -wave(x); })), 2.0, 1e-12);
  // Linear between points: off by at most x^2 w^2 / 8 of the wave.
  EXPECT_LT(curve_error(hidden, law(wave, 21)), 0.05);
  EXPECT_GT(curve_error(hidden, law(wave, 21)), 0.0);
  // In any order, and level beyond its ends.
  LawRecord backwards = hidden;
  std::reverse(backwards.curve.begin(), backwards.curve.end());
  EXPECT_NEAR(curve_error(hidden, backwards), 0.0, 1e-12);
  EXPECT_NEAR(curve_error(hidden, LawRecord{"link", {"q"}, {{{0.0}, 4.0}}, {}}), 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(curve_error(law([](double x) { return 3.0 * x; }), hidden))) << "a line has no form";
  EXPECT_TRUE(std::isnan(curve_error(hidden, LawRecord{})));
}

TEST(BlindLaws, ACurveOverTwoVariablesTakesTheNearestRow) {
  const auto bell = [](double x) { return std::exp(-9.0 * x * x); };
  const auto both = [&](double size, double row) {
    LawRecord out{"link", {"q", "v"}, {}, {}};
    for (const double direction : {-row, row})
      for (int k = 0; k <= 40; ++k) {
        const double x = -1.0 + 0.05 * k;
        // With a plain Coulomb friction, which is not the law's own.
        out.curve.push_back({{x, direction}, (direction < 0.0 ? 1.0 : -1.0) * (size * bell(x) + 2.0 * (size - 1.0))});
      }
    return out;
  };
  EXPECT_NEAR(curve_error(both(1.0, 1.0), both(1.0, 0.8)), 0.0, 1e-12);
  EXPECT_NEAR(curve_error(both(1.0, 1.0), both(1.25, 1.0)), 0.25, 1e-12);
}

TEST(BlindLaws, EventsAreFoundAtTheirJointAndEdges) {
  BlindLabel::Effect hidden{"external_push", "joint_1", 3.0};
  hidden.law = happened("link", {{"a.csv", 2.0, 2.4, 3.0}, {"b.csv", 5.0, 5.4, 3.0}});
  const auto found = [&](const std::string& place, const LawRecord::Event& said) {
    return score_case(learned_case(hidden, {{place, happened("link", {said})}})).laws.at(0).found;
  };
  EXPECT_EQ(found("joint_1", {"a.csv", 2.09, 2.31, {}}), 1);
  EXPECT_EQ(found("joint_1", {"a.csv", 2.11, 2.4, {}}), 0);
  EXPECT_EQ(found("joint_1", {"a.csv", 2.0, 2.6, {}}), 0);
  EXPECT_EQ(found("joint_1", {"b.csv", 2.0, 2.4, {}}), 0);
  EXPECT_EQ(found("joint_2", {"a.csv", 2.0, 2.4, {}}), 0);
  EXPECT_TRUE(std::isnan(score_case(learned_case(hidden, {})).laws.at(0).curve_error));
}

TEST(BlindLaws, TotalsSayWhatWasLearnedAndWhatShouldNotHaveBeen) {
  BlindLabel::Effect ripple = kRipple, push{"external_push", "joint_1", 3.0};
  ripple.law = law(wave);
  push.law = happened("link", {{"a.csv", 2.0, 2.4, 3.0}, {"b.csv", 5.0, 5.4, 3.0}});
  std::vector<BlindCase> cases{
      learned_case(ripple, {{"joint_1", law([](double x) { return 0.9 * wave(x); })}}),
      learned_case(ripple, {{"joint_2", law(wave)}}),
      learned_case(push, {{"joint_1", happened("link", {{"a.csv", 2.0, 2.4, {}}, {"a.csv", 7.0, 8.0, {}}})}}),
      one_case({}, "consistent"),
      one_case({}, "unknown_physics"),
      one_case({kFriction}, "missing_physics", {claim("coulomb_friction", "joint_2")})};
  cases[0].verdict->after = {{"joint_1", 1.1}, {"joint_2", 1.2}};  // 1.1511 of the noise
  cases[1].verdict->after = {{"joint_1", 1.1}, {"joint_2", 1.1}};
  cases[4].verdict->learned = {{"joint_1", law(wave)}};
  cases.push_back(learned_case(ripple, {}));
  cases.back().verdict.reset();  // failed: nothing is right
  const BlindTotals t = total(cases);
  const auto counts = [](const Rate& rate) { return std::pair(rate.hits, rate.of); };
  EXPECT_EQ(counts(t.laws.place), std::pair(2, 4));
  EXPECT_EQ(counts(t.laws.over), std::pair(2, 4));
  EXPECT_EQ(counts(t.laws.events), std::pair(1, 2));
  EXPECT_EQ(counts(t.events_true), std::pair(1, 2));
  EXPECT_EQ(counts(t.laws.at_noise), std::pair(1, 4));
  EXPECT_EQ(counts(t.laws_of.at("position_ripple").unknown), std::pair(2, 3));
  EXPECT_EQ(t.laws.curves, 3);
  EXPECT_NEAR(t.laws.median_error(), 0.1, 1e-12);
  EXPECT_EQ(counts(t.false_laws_null), std::pair(1, 2));
  EXPECT_EQ(counts(t.false_laws_exact), std::pair(0, 1));
  const auto record = nlohmann::json::parse(to_json(cases, sample::context()));
  const auto& outside = record.at("totals").at("outside");
  EXPECT_EQ(outside.at("by_effect").at("external_push").at("events").at("hits"), 1);
  EXPECT_EQ(outside.at("false_laws").at("null").at("hits"), 1);
  EXPECT_EQ(record.at("cases")[0].at("outside")[0].at("over_right"), true);
  EXPECT_NE(blind_page(cases, "cases", sample::context()).find("<h2>Outside the catalogue</h2>"), std::string::npos);
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

}  // namespace
}  // namespace lacuna
