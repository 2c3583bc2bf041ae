#include "compare/simulators.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenarios/error.h"
#include "tests/compare/scenarios.h"

namespace lacuna {
namespace {

SimulatorSide side(double step, std::vector<FoundNumber> numbers) {
  SimulatorSide out;
  out.step = step, out.numbers = std::move(numbers);
  return out;
}

TEST(TellApart, WhatShrinksWithTheStepIsTheIntegratorsAndWhatStaysIsPhysics) {
  // First order: 0.4 at h, 0.2 at h/2 on top of what stays.
  const auto numbers =
      tell_apart(side(2e-3, {{"a.gain", "N m", 10.4, 0.1},
                             {"a.damping", "N m s/rad", 5.01, 0.1},
                             {"a.stiffness", "N m/rad", 33.0, 0.1},
                             {"a.coulomb_friction.Fc", "N m", 2.4, 0.05},
                             {"a.input_delay.T", "s", 1e-3, 1e-5}}),
                 side(1e-3, {{"a.gain", "N m", 10.2, 0.1},
                             {"a.damping", "N m s/rad", 5.0, 0.1},
                             {"a.stiffness", "N m/rad", 33.0, 0.1},
                             {"a.coulomb_friction.Fc", "N m", 2.2, 0.05},
                             {"a.input_delay.T", "s", 5e-4, 1e-5}}),
                 std::vector<std::pair<std::string, double>>{
                     {"a.gain", 10.0}, {"a.damping", 5.0}, {"a.stiffness", 30.0}, {"a.coulomb_friction.Fc", 1.0}},
                 1.0);
  ASSERT_EQ(numbers.size(), 5u);
  EXPECT_EQ(numbers[0].origin, Origin::integrator);
  EXPECT_NEAR(numbers[0].at_zero, 10.0, 1e-12);
  EXPECT_NEAR(numbers[0].integrator, 0.4, 1e-12);
  EXPECT_EQ(numbers[1].origin, Origin::as_built);
  EXPECT_EQ(numbers[2].origin, Origin::physics);
  EXPECT_NEAR(numbers[2].physics, 3.0, 1e-12);
  EXPECT_EQ(numbers[3].origin, Origin::both);
  EXPECT_EQ(numbers[4].origin, Origin::integrator) << "a delay of half a step is nothing that was built";
  EXPECT_TRUE(std::isnan(numbers[4].given));
}

TEST(TellApart, AnEffectOnOneSideAloneCountsAsNoneOnTheOther) {
  const auto numbers =
      tell_apart(side(2e-3, {{"a.input_delay.T", "s", 1e-3, 1e-5}, {"a.gain", "", 1.0, 0.1}}), side(1e-3, {}), {}, 1.0);
  ASSERT_EQ(numbers.size(), 1u) << "a plain number that one side lacks cannot be compared";
  EXPECT_EQ(numbers[0].at_half, 0.0);
  EXPECT_EQ(numbers[0].origin, Origin::integrator);
}

TEST(OriginOfRest, GoesByTheEnergyBeyondTheNoise) {
  EXPECT_EQ(origin_of_rest(1.0, 1.05, 1.0), Origin::as_built);
  EXPECT_EQ(origin_of_rest(1.0, 3.0, 3.0), Origin::physics);
  EXPECT_EQ(origin_of_rest(1.0, std::sqrt(5.0), std::sqrt(2.0)), Origin::integrator) << "a quarter: first order";
  EXPECT_EQ(origin_of_rest(1.0, std::sqrt(5.0), std::sqrt(3.6)), Origin::both);
  EXPECT_EQ(origin_of_rest(1.0, 1.0, 3.0), Origin::physics) << "what comes up at the shorter step is no integrator's";
}

TEST(StepDependence, FindsOrderAndErrorOfAPlantedError) {
  const Scenario scenario = test::compared_scenario("double_pendulum");
  for (const double order : {1.0, 2.0}) {
    std::vector<Trajectory> runs(3);
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 100; ++i) {
        const double t = 0.01 * i, error = 0.01 * std::sin(t) * std::pow(0.5, order * k);
        runs[k].q.push_back({std::cos(t) + error, 0.0});
      }
    const auto found = step_dependence(*scenario.robot, runs);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_NEAR(found[0].order, order, 1e-9);
    double sum = 0.0;
    for (int i = 0; i < 100; ++i) sum += std::pow(0.01 * std::sin(0.01 * i), 2);
    EXPECT_NEAR(found[0].error_at_step, std::sqrt(sum / 100), 1e-12);
    EXPECT_TRUE(std::isnan(found[1].order)) << "a joint that no step moves shows no order";
    EXPECT_EQ(found[1].error_at_step, 0.0);
    const std::vector<std::vector<StepDependence>> twice{found, found};
    EXPECT_NEAR(pooled(twice)[0].error_at_step, found[0].error_at_step, 1e-15);
  }
}

TEST(NativePlant, TakesDampingAndFrictionToTheEngineAndKeepsWhatWasBuilt) {
  Scenario scenario = test::compared_scenario("arm_step");
  const NativePlant plant = native_plant(scenario, 0.0);
  const auto given = [&](const NativePlant& of, const std::string& name) {
    for (const auto& [key, value] : of.given)
      if (key == name) return value;
    return std::nan("");
  };
  ASSERT_FALSE(scenario.actuators.empty());
  for (const ActuatorSpec& spec : plant.scenario.actuators) EXPECT_EQ(spec.parameters.at("damping"), 0.0);
  const ActuatorSpec& first = scenario.actuators.front();
  const std::size_t joint = *scenario.robot->find_joint(first.joint);
  EXPECT_EQ(plant.losses[joint].damping, first.parameters.at("damping"));
  EXPECT_EQ(given(plant, first.joint + ".damping"), first.parameters.at("damping"));
  EXPECT_EQ(given(plant, first.joint + ".gain"), first.parameters.at("gain"));
  EXPECT_EQ(plant.losses[joint].friction, 0.0);
  scenario.effects = {{"coulomb_friction", first.joint, {{"Fc", 7.0}}, {}, "test"}};
  const NativePlant rubbing = native_plant(scenario, 0.5);
  EXPECT_EQ(rubbing.losses[joint].friction, 7.0) << "what is stated stands before the share";
  EXPECT_TRUE(rubbing.scenario.effects.empty());
  EXPECT_EQ(given(rubbing, first.joint + ".coulomb_friction.Fc"), 7.0);
  EXPECT_THROW(native_plant(scenario, -0.1), InputError);
}

}  // namespace
}  // namespace lacuna
