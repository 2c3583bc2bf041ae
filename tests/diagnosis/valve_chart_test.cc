// Charts of speed against command: what they show of a valve that another engine moved, and where they are none.
#include "diagnosis/valve_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.h"
#include "diagnosis/valve_start.h"
#include "tests/diagnosis/valve_blocks.h"

namespace lacuna {
namespace {

using namespace test;

double rms_of(const ValveChart& chart, Role role) {
  return std::ranges::find_if(chart.rms, [&](const auto& entry) { return entry.first == role; })->second;
}

TEST(ValveChart, HasTheSpeedsOfAWornValve) {
  Scenario scenario = valve_block(worn_valve());
  scenario.prediction = Windows{2.0};
  const auto charts = valve_charts(PlantModel(scenario), make_experiment(scenario));
  ASSERT_EQ(charts.size(), 1u);
  const ValveChart& chart = charts.front();
  EXPECT_NEAR(chart.delay + chart.lag, 0.11, 0.02);
  const double step = chart.command[1] - chart.command[0];
  for (std::size_t k = 0; k < chart.command.size(); ++k) {
    if (chart.seen[k] < 0.5) continue;
    // Straight lines round the corners off within a step.
    EXPECT_NEAR(chart.speed[k], speed_of_worn_valve(chart.command[k]), 0.3 * kValveGain * step) << chart.command[k];
  }
  EXPECT_LT(rms_of(chart, Role::test), 5e-3);
  EXPECT_TRUE(std::isinf(chart.stops[0]) && std::isinf(chart.stops[1]));
}

TEST(ValveChart, IsThatOfTheGainWhereTheValveIsSound) {
  Scenario scenario = valve_block({});
  scenario.prediction = Windows{2.0};
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const ValveChart chart = valve_charts(model, experiment).front();
  EXPECT_LT(chart.delay + chart.lag, 0.02);
  for (std::size_t k = 0; k < chart.command.size(); ++k)
    if (chart.seen[k] > 0.5) {
      EXPECT_NEAR(chart.speed[k], kValveGain * chart.command[k], 0.01 * kValveGain * 6.0);
    }
  const ValveStart start = valve_starts(model, experiment).front();
  EXPECT_NEAR(start.gain, kValveGain, 0.01 * kValveGain);
  EXPECT_TRUE(start.effects.empty()) << start.effects.front().effect;
}

TEST(ValveChart, ShowsWhereTheJointStandsAgainstItsDrive) {
  Scenario scenario = valve_block({effect("end_stop", "slide", {{"q_lim", 0.15}, {"k", 1e7}})});
  scenario.prediction = Windows{2.0};
  const ValveChart chart = valve_charts(PlantModel(scenario), make_experiment(scenario)).front();
  EXPECT_NEAR(chart.stops[1], 0.15, 2e-3);
  EXPECT_TRUE(std::isinf(chart.stops[0]));
}

TEST(ValveChart, IsOfDrivesThatIntegrateTheirFlowOnly) {
  Scenario scenario = valve_block({});
  scenario.actuators = {actuator("slide", "torque_source", {{"gain", 1.0}, {"damping", 2.0}, {"stiffness", 0.0}})};
  EXPECT_TRUE(valve_charts(PlantModel(scenario), make_experiment(scenario)).empty());
}

constexpr double kOfTheChart = 0.1;  // of a number: straight lines round the corners off

TEST(ValveStart, NamesWhatTheChartShowsAndNothingElse) {
  Scenario scenario = valve_block(worn_valve());
  scenario.prediction = Windows{2.0};
  const PlantModel model(scenario);
  const auto starts = valve_starts(model, make_experiment(scenario));
  ASSERT_EQ(starts.size(), 1u);
  const std::map<std::string, std::pair<std::string, double>> truth{
      {"valve_deadband", {"d", 1.5}}, {"valve_asymmetry", {"a", 0.3}}, {"actuator_saturation", {"cap", 2.0}}};
  std::size_t found = 0;
  for (const EffectSpec& spec : starts.front().effects) {
    if (spec.effect == "input_delay" || spec.effect == "actuator_lag") continue;  // either, or some of both
    ASSERT_EQ(truth.count(spec.effect), 1u) << spec.effect;
    const auto& [number, value] = truth.at(spec.effect);
    EXPECT_NEAR(spec.parameters.at(number), value, kOfTheChart * value) << spec.effect;
    if (spec.effect == "actuator_saturation") {
      EXPECT_GT(spec.parameters.at("n"), 5.0);  // a corner; a round bend is 3
    }
    ++found;
  }
  EXPECT_EQ(found, truth.size());
  EXPECT_NEAR(starts.front().gain, kValveGain, kOfTheChart * kValveGain);
}

TEST(ValveOpening, IsSoughtWhereTheCommandLetsAFlow) {
  Scenario scenario = valve_block({});
  const EffectInfo& opening = effect_table()[find_effect("valve_opening")];
  const auto places = [&] {
    const PlantModel model(scenario);
    return places_of(opening, {model, SearchSpace(model, scenario), {1.0}, {}}, make_experiment(scenario));
  };
  ASSERT_EQ(places().size(), 1u);
  EXPECT_EQ(places().front().place, "slide");
  scenario.actuators = {actuator("slide", "torque_source", {{"gain", 1.0}, {"damping", 2.0}, {"stiffness", 0.0}})};
  EXPECT_TRUE(places().empty());
}

TEST(ValveStart, IsWhereASearchBegins) {
  Scenario scenario = valve_block(worn_valve());
  scenario.prediction = Windows{2.0};
  const Experiment experiment = make_experiment(scenario);
  const PlantModel model(scenario);
  const CurrentModel plain{model, SearchSpace(model, scenario), {1.0}, {}};
  const EffectSpec spec = effect("actuator_saturation", "slide", {{"cap", 2.0}, {"n", 3.0}});
  const ScreenedEffect start = start_at(plain, experiment, spec);
  ASSERT_EQ(start.own.size(), 1u);  // the sharpness is neutral: fixed
  EXPECT_EQ(start.spec.parameters.at("n"), 3.0);
  EXPECT_NEAR(start.own.front(), 1.0 / 2.0, 1e-12);  // searched by its inverse
}

}  // namespace
}  // namespace lacuna
