// Sets of effects: what one has over another, and the search that goes on where single effects leave a rest.
#include "diagnosis/set_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/baseline.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kReading = 1e-3;  // rad, noise of a reading
constexpr int kIterations = 30;
const EffectSpec kDeadbandThere{"valve_deadband", "swing", {}, {}, "test"};
const EffectSpec kAsymmetryThere{"valve_asymmetry", "swing", {}, {}, "test"};

/// A pendulum whose recordings another engine made, its plain model identified.
struct Pendulum {
  explicit Pendulum(std::vector<EffectSpec> concealed)
      : scenario(pendulum_problem({2.2, 1.1, 5.0, 1.0}, {"gain", "damping", "stiffness"}, kReading,
                                  std::move(concealed), 10.0, available_engines().back())),
        model(scenario),
        experiment(make_experiment(scenario)),
        at(on("featherstone", 0.005)) {
    FitResult fit;
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.simulator = at;
    options.step = at.max_step;
    plain = identify_plain(model, experiment, SearchSpace(model, scenario), options, fit);
  }

  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SimulatorOptions at;
  std::optional<CurrentModel> plain;
};

/// One whose valve has a deadband of .5 V and opens to one side a fifth wider.
const Pendulum& valve() {
  static const Pendulum out(
      {effect("valve_deadband", "swing", {{"d", 0.5}}), effect("valve_asymmetry", "swing", {{"a", 0.2}})});
  return out;
}
const Pendulum& complete() {
  static const Pendulum out({});
  return out;
}

TEST(Hypotheses, PreferWhatActedOnTrainAndOnHeldOutRecordings) {
  const Pendulum& p = valve();
  Hypotheses sets(*p.plain, p.experiment, p.at, {});
  const Hypothesis none = sets.none(kIterations);
  const auto one = sets.changed(none, {{kDeadbandThere}, {{0.1}}, {}, {}, {}}, kIterations);
  ASSERT_TRUE(one);
  const auto both = sets.changed(*one, {{kAsymmetryThere}, {{0.05}}, {}, {}, {}}, kIterations);
  ASSERT_TRUE(both);
  EXPECT_GT(sets.log_odds(*one, none), 10.0);
  EXPECT_GT(sets.log_odds(*both, *one), 10.0);
  EXPECT_GT(sets.heldout_difference(*both, *one).gain, 10.0);
  for (const EffectSpec& spec : both->effects) {
    EXPECT_TRUE(sets.is_determined(*both, spec)) << spec.effect;
    EXPECT_TRUE(sets.ends_within(*both, spec)) << spec.effect;
  }
  const std::vector<std::size_t> deadband = own_axes(both->model, kDeadbandThere);
  ASSERT_EQ(deadband.size(), 1u);
  EXPECT_NEAR(both->model.fit.point[deadband.front()], 0.5, 0.02);
}

TEST(Hypotheses, OddsTurnRoundWithTheirOrder) {
  const Pendulum& p = valve();
  Hypotheses sets(*p.plain, p.experiment, p.at, {});
  const Hypothesis none = sets.none(kIterations);
  const auto one = sets.changed(none, {{kDeadbandThere}, {{0.1}}, {}, {}, {}}, kIterations);
  ASSERT_TRUE(one);
  sets.settle(*one);
  const double odds = sets.log_odds(*one, none);
  EXPECT_NEAR(odds, -sets.log_odds(none, *one), 1e-9 * std::fabs(odds));
}

TEST(Hypotheses, WhatIsTakenOutLeavesTheSetBeforeIt) {
  const Pendulum& p = valve();
  Hypotheses sets(*p.plain, p.experiment, p.at, {});
  const Hypothesis none = sets.none(kIterations);
  const auto one = sets.changed(none, {{kDeadbandThere}, {{0.1}}, {}, {}, {}}, kIterations);
  ASSERT_TRUE(one);
  const auto again = sets.changed(*one, {{}, {}, {place_of(kDeadbandThere)}, {}, {}}, kIterations);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->effects.empty());
  ASSERT_EQ(again->model.fit.point.size(), none.model.fit.point.size());
  for (std::size_t a = 0; a < none.model.fit.point.size(); ++a)
    EXPECT_NEAR(again->model.fit.point[a], none.model.fit.point[a], 1e-3 * std::fabs(none.model.fit.point[a]));
}

TEST(Hypotheses, AnEffectThatIsNotThereIsNotDetermined) {
  const Pendulum& p = complete();
  Hypotheses sets(*p.plain, p.experiment, p.at, {});
  const Hypothesis none = sets.none(kIterations);
  const auto one = sets.changed(none, {{kAsymmetryThere}, {{0.05}}, {}, {}, {}}, kIterations);
  ASSERT_TRUE(one);
  EXPECT_LT(sets.log_odds(*one, none), 0.0);
  EXPECT_FALSE(sets.is_determined(*one, kAsymmetryThere));
}

TEST(SetSearch, FindsTogetherWhatTheValveHas) {
  const Pendulum& p = valve();
  ASSERT_TRUE(leaves_a_rest(*p.plain, p.experiment, p.at));
  const auto found = search_sets(*p.plain, *p.plain, {}, p.experiment, {p.at, {}, 1, {}});
  ASSERT_TRUE(found);
  EXPECT_FALSE(leaves_a_rest(found->model, p.experiment, found->simulator));
  for (const char* name : {"valve_deadband", "valve_asymmetry"}) {
    const auto at = std::find_if(found->findings.begin(), found->findings.end(),
                                 [&](const Finding& f) { return f.effect == name; });
    ASSERT_NE(at, found->findings.end()) << name;
    EXPECT_GT(at->probability, 0.9) << name;
    EXPECT_GT(at->heldout_gain, 0.0) << name;
    EXPECT_EQ(at->place, "swing");
  }
  EXPECT_EQ(found->findings.size(), 2u);
}

TEST(SetSearch, HasNothingToAddWhereNothingIsMissing) {
  const Pendulum& p = complete();
  EXPECT_FALSE(leaves_a_rest(*p.plain, p.experiment, p.at));
  EXPECT_FALSE(search_sets(*p.plain, *p.plain, {}, p.experiment, {p.at, {}, 1, {}}));
}

}  // namespace
}  // namespace lacuna
