// Sets of effects: what one has over another, and the search that goes on where single effects leave a rest.
#include "diagnosis/set_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnosis/baseline.h"
#include "tests/diagnosis/valve_blocks.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kSetReading = 1e-3;  // rad, noise of a reading
constexpr int kIterations = 30;
const EffectSpec kDeadbandThere{"valve_deadband", "swing", {}, {}, "test"};
const EffectSpec kAsymmetryThere{"valve_asymmetry", "swing", {}, {}, "test"};

/// A pendulum whose recordings another engine made, its plain model identified.
struct Pendulum {
  explicit Pendulum(std::vector<EffectSpec> concealed)
      : scenario(pendulum_problem({2.2, 1.1, 5.0, 1.0}, {"gain", "damping", "stiffness"}, kSetReading,
                                  std::move(concealed), 10.0, engine_of_data())),
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

  FitContext context() const { return {experiment, at}; }

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

/// The sets of one pendulum: that without effects, and others grown from it.
struct Sets {
  explicit Sets(const Pendulum& p) : all(*p.plain, p.context()), none(all.none(kIterations)) {}
  /// `from` with an effect more, fitted from `start`.
  Hypothesis with(const Hypothesis& from, const EffectSpec& spec, double start) const {
    std::optional<Hypothesis> out = all.changed(from, {{spec}, {{start}}, {}, {}, {}}, kIterations);
    if (!out) throw std::runtime_error("cannot be simulated");
    return *out;
  }
  Hypotheses all;
  Hypothesis none;
};

TEST(Hypotheses, TellAStrengthThatIsNoneAtInfinity) {
  const EffectSpec saturation{"actuator_saturation", "swing", {{"n", 3.0}}, {}, "test"};
  const Pendulum saturated({effect("actuator_saturation", "swing", {{"cap", 2.0}})});
  Sets there(saturated), nowhere(complete());
  const double start = 1.0 / 4.0;  // it is searched by its inverse
  EXPECT_TRUE(there.all.is_determined(there.with(there.none, saturation, start), saturation));
  EXPECT_FALSE(nowhere.all.is_determined(nowhere.with(nowhere.none, saturation, start), saturation));
}

TEST(Hypotheses, PreferWhatActedOnTrainAndOnHeldOutRecordings) {
  Sets sets(valve());
  const Hypothesis one = sets.with(sets.none, kDeadbandThere, 0.1);
  const Hypothesis both = sets.with(one, kAsymmetryThere, 0.05);
  EXPECT_GT(sets.all.log_odds(one, sets.none), 10.0);
  EXPECT_GT(sets.all.log_odds(both, one), 10.0);
  EXPECT_GT(sets.all.heldout_difference(both, one).gain, 10.0);
  for (const EffectSpec& spec : both.effects) {
    EXPECT_TRUE(sets.all.is_determined(both, spec)) << spec.effect;
    EXPECT_TRUE(sets.all.ends_within(both, spec)) << spec.effect;
  }
  const std::vector<std::size_t> deadband = own_axes(both.model, kDeadbandThere);
  ASSERT_EQ(deadband.size(), 1u);
  EXPECT_NEAR(both.model.fit.point[deadband.front()], 0.5, 0.02);
}

TEST(Hypotheses, RowsOfAFitAreThoseOfItsSimulationsInAnyWeights) {
  Sets sets(valve());
  const Hypothesis one = sets.with(sets.none, kDeadbandThere, 0.1);
  const std::vector<double> weights{3.0 * one.model.weights.front()};
  Problem problem = problem_of(one.model, valve().context(), weights);
  const Eigen::VectorXd at = problem.residual(one.model.fit.point, sets.all.train());
  const Eigen::MatrixXd J = problem.jacobian(one.model.fit.point, at, sets.all.train());
  const FittedRows rows = sets.all.rows(one.model, weights);
  EXPECT_LT((rows.residual - at).norm(), 1e-9 * at.norm());
  for (std::size_t a = 0; a < rows.columns.size(); ++a) {
    const auto column = J.col(a);
    EXPECT_LT((rows.columns[a].train - column).norm(), 1e-5 * column.norm()) << a;
  }
}

TEST(Hypotheses, OddsTurnRoundWithTheirOrder) {
  Sets sets(valve());
  const Hypothesis one = sets.with(sets.none, kDeadbandThere, 0.1);
  sets.all.settle(one);
  const double odds = sets.all.log_odds(one, sets.none);
  EXPECT_NEAR(odds, -sets.all.log_odds(sets.none, one), 1e-9 * std::fabs(odds));
}

TEST(Hypotheses, WhatIsTakenOutLeavesTheSetBeforeIt) {
  Sets sets(valve());
  const Hypothesis one = sets.with(sets.none, kDeadbandThere, 0.1);
  const auto again = sets.all.changed(one, {{}, {}, {place_of(kDeadbandThere)}, {}, {}}, kIterations);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->effects.empty());
  ASSERT_EQ(again->model.fit.point.size(), sets.none.model.fit.point.size());
  for (std::size_t a = 0; a < sets.none.model.fit.point.size(); ++a)
    EXPECT_NEAR(again->model.fit.point[a], sets.none.model.fit.point[a],
                1e-3 * std::fabs(sets.none.model.fit.point[a]));
}

TEST(Hypotheses, AnEffectThatIsNotThereIsNotDetermined) {
  const Sets sets(complete());
  const Hypothesis one = sets.with(sets.none, kAsymmetryThere, 0.05);
  EXPECT_LT(sets.all.log_odds(one, sets.none), 0.0);
  EXPECT_FALSE(sets.all.is_determined(one, kAsymmetryThere));
}

TEST(Hypotheses, RefuseAStopThatItsDriveWouldPushThrough) {
  const Pendulum& p = complete();
  const Hypotheses all(*p.plain, p.context());
  const double size = typical_size(Scale::stiffness, p.model, p.experiment, 0, p.model.values());
  for (const double stiffness : {-30.0, -3.0, 3.0, 30.0}) {
    const EffectSpec spec{"end_stop", "swing", {{"travel", 1e6}}, {}, "test"};
    const Hypothesis stop{{spec},
                          extended(*p.plain, p.experiment, spec, p.plain->fit.point, {0.0, stiffness * size, 0.0})};
    EXPECT_EQ(all.ends_within(stop, spec), std::fabs(stiffness) > 10.0) << stiffness;
  }
}

TEST(SetSearch, FindsTogetherWhatTheValveHas) {
  const Pendulum& p = valve();
  ASSERT_TRUE(leaves_a_rest(*p.plain, p.context()));
  const auto found = search_sets(*p.plain, *p.plain, {}, p.context(), {});
  ASSERT_TRUE(found);
  EXPECT_FALSE(leaves_a_rest(found->model, p.context().with_step(found->step)));
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

TEST(SetSearch, HoldsWhatWasFoundBeforeAgainstItsRivals) {
  // The asymmetry was found alone, beside a rival that explains most of it; the deadband is the set search's to find.
  const Pendulum& p = valve();
  CurrentModel one = extended(*p.plain, p.experiment, kAsymmetryThere, p.plain->fit.point, {0.05});
  refine(one, p.context());
  Finding found;
  found.effect = "valve_asymmetry", found.place = "swing", found.members = {"valve_asymmetry"};
  found.rivals = {{"valve_offset", "swing", 0.0, {}, {0.05}, {}}};
  SetSearchOptions options;
  const std::optional<SetSearchResult> with = search_sets(*p.plain, one, {found}, p.context(), options);
  ASSERT_TRUE(with);
  const auto asymmetry = std::find_if(with->findings.begin(), with->findings.end(),
                                      [](const Finding& f) { return f.effect == "valve_asymmetry"; });
  ASSERT_NE(asymmetry, with->findings.end());
  EXPECT_TRUE(std::any_of(asymmetry->rivals.begin(), asymmetry->rivals.end(),
                          [](const Rival& r) { return r.effect == "valve_offset"; }));
}

/// A block behind a valve with that in it, predicted over 2 s, its gain identified.
struct Block {
  explicit Block(std::vector<EffectSpec> concealed)
      : scenario(valve_block(std::move(concealed))), at(on("featherstone", 0.005)) {
    scenario.prediction = Windows{2.0};
    scenario.identify = {{"gain", true, 0.2, 5.0, "test: identify.gain"}};
    model.emplace(scenario);
    experiment = make_experiment(scenario);
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.simulator = at;
    options.step = at.max_step;
    FitResult fit;
    plain = identify_plain(*model, experiment, SearchSpace(*model, scenario), options, fit);
  }

  FitContext context() const { return {experiment, at}; }

  Scenario scenario;
  SimulatorOptions at;
  std::optional<PlantModel> model;
  Experiment experiment;
  std::optional<CurrentModel> plain;
};

TEST(SetSearch, BeginsWithTheWholeValveThatTheRecordingsShow) {
  const Block block(worn_valve());
  SetSearchOptions with{1, {}, {}, valve_starts(*block.model, block.experiment)};
  // Alone, so that nothing but the start can have brought them.
  with.skipped = [&](const EffectSpec& spec) {
    return std::ranges::none_of(with.valves.front().effects,
                                [&](const EffectSpec& e) { return e.effect == spec.effect; });
  };
  const auto found = search_sets(*block.plain, *block.plain, {}, block.context(), with);
  ASSERT_TRUE(found);
  for (const char* name : {"valve_deadband", "valve_asymmetry", "actuator_saturation"}) {
    EXPECT_GE(found->model.model.find_effect_at(name, "slide"), 0) << name;
    EXPECT_TRUE(std::ranges::any_of(found->findings, [&](const Finding& f) { return f.effect == name; })) << name;
  }
  const int d = found->model.model.find("slide.valve_deadband.d");
  ASSERT_GE(d, 0);
  EXPECT_NEAR(found->model.space.expand(found->model.fit.point)[d], 1.5, 0.1);
}

TEST(SetSearch, FreesTheOppositeStopOfOneThatWasFound) {
  const double far = 0.8;  // m, between both
  const Block block({effect("end_stop", "slide", {{"q_lim", 0.3}, {"k", 1e6}, {"travel", far}})});
  const EffectSpec one_stop{"end_stop", "slide", {{"T", 0.0}, {"travel", 1e6}}, {}, "test"};
  CurrentModel one = extended(*block.plain, block.experiment, one_stop, block.plain->fit.point, {0.3, 1e6});
  refine(one, block.context());
  Finding found;
  found.effect = "end_stop", found.place = "slide", found.members = {"end_stop"}, found.fixed = one_stop.parameters;
  SetSearchOptions options;
  options.skipped = [](const EffectSpec&) { return true; };
  const std::optional<SetSearchResult> with = search_sets(*block.plain, one, {found}, block.context(), options);
  ASSERT_TRUE(with);
  const std::size_t travel = with->model.model.find("slide.end_stop.travel");
  EXPECT_NEAR(with->model.space.expand(with->model.fit.point)[travel], far, 2e-3);
}

TEST(SetSearch, HasNothingToAddWhereNothingIsMissing) {
  const Pendulum& p = complete();
  EXPECT_FALSE(leaves_a_rest(*p.plain, p.context()));
  EXPECT_FALSE(search_sets(*p.plain, *p.plain, {}, p.context(), {}));
}

TEST(SetSearch, ClaimsNothingThatNoRecordingWasKeptToProve) {
  const Pendulum& p = valve();
  Experiment unproved = p.experiment;
  for (Segment& segment : unproved.segments)
    if (segment.role == Role::validate) segment.role = Role::train;
  EXPECT_FALSE(search_sets(*p.plain, *p.plain, {}, p.context().on(unproved), {}));
}

}  // namespace
}  // namespace lacuna
