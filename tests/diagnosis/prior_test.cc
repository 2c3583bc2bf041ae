// What is held for likely before any data: ranges of effects' numbers, and the drives' gains.
#include "diagnosis/prior.h"

#include <gtest/gtest.h>

#include "physics/effects/creep.h"
#include "physics/effects/table.h"
#include "tests/physics/efforts.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kMass = 2.0, kHalf = 0.1;  // kg; an interval that white noise alone would leave
constexpr double kTenth = 1.96 * 0.1;       // of a mass, two standard errors: how well drives' gains are known

Scenario measured_efforts(bool masses_searched, std::vector<EffectSpec> effects = {}) {
  Scenario out = pushed_rods(std::move(effects));
  out.prediction = InverseDynamics{8.0};
  out.identify = {{"damping", true, 0.2, 5.0, "test: identify"}};
  if (masses_searched) out.identify.push_back({"mass", true, 0.3, 3.0, "test: identify"});
  add_recording(out, truth_recording(pushed_rods(), sines_at(clock(4.0, 0.002), 6.0), "train.csv"), Role::train);
  return out;
}

/// Upper ends of what has this name, after the drives' gains were taken into account.
double carried(const Scenario& scenario, const std::string& name) {
  const PlantModel model(scenario);
  std::vector<Estimate> estimates{{name, "kg", kMass, kMass - kHalf, kMass + kHalf}};
  carry_scale_error(model, SearchSpace(model, scenario, Coordinates::ratios), make_experiment(scenario), estimates);
  EXPECT_NEAR(estimates[0].upper95 - kMass, kMass - estimates[0].lower95, 1e-12);
  return estimates[0].upper95;
}

std::string mass_of_the_last_link(const Scenario& scenario) { return scenario.robot->links().back().name + ".mass"; }

TEST(ScaleError, WidensMassesThatOnlyEffortsTell) {
  const Scenario scenario = measured_efforts(true);
  EXPECT_NEAR(carried(scenario, mass_of_the_last_link(scenario)), kMass + std::hypot(kHalf, kTenth * kMass), 1e-12);
}

TEST(ScaleError, LeavesWhatIsNoMassAlone) {
  EXPECT_EQ(carried(measured_efforts(true), "elbow.damping"), kMass + kHalf);
}

TEST(ScaleError, IsNoneWhereTheLinksMassesAreGiven) {
  const Scenario scenario = measured_efforts(false);
  EXPECT_EQ(carried(scenario, mass_of_the_last_link(scenario)), kMass + kHalf);
}

TEST(ScaleError, IsNoneWhereALoadOfStatedMassIsCarried) {
  const Scenario scenario = measured_efforts(true, {effect("payload", "arm", {{"m", 0.5}})});
  EXPECT_EQ(carried(scenario, mass_of_the_last_link(scenario)), kMass + kHalf);
}

TEST(ScaleError, IsNoneWhereMotionsAreSimulated) {
  Scenario scenario = measured_efforts(true);
  scenario.prediction = FreeRun{};
  scenario.channels.of.erase(ChannelKind::effort);
  EXPECT_EQ(carried(scenario, mass_of_the_last_link(scenario)), kMass + kHalf);
}

TEST(EffectAxes, AnArmatureMayBeWhatTheEffortsCouldDrive) {
  // A wrist's last link weighs nothing beside the motor behind its gear.
  const Scenario scenario = measured_efforts(true);
  const Experiment experiment = make_experiment(scenario);
  const EffectSpec spec = effect("armature", "elbow", {});
  const PlantModel model = PlantModel(scenario).with_effects({spec});
  const std::vector<Axis> axes = effect_axes(model, experiment, model.effects().back(), spec);
  ASSERT_EQ(axes.size(), 1u);
  const int elbow = 1;
  EXPECT_GE(axes[0].upper, 100.0 * driven_inertia(model, experiment, elbow));
}

TEST(DrivenInertia, IsEffortOverTheAccelerationOfTheMotionSeen) {
  const Scenario scenario = measured_efforts(true);
  const Experiment experiment = make_experiment(scenario);
  const double effort = experiment.effort_rms[0], way = experiment.position_rms[0], speed = experiment.speed_rms[0];
  EXPECT_NEAR(driven_inertia(PlantModel(scenario), experiment, 0), effort * way / (speed * speed), 1e-12);
}

TEST(CreepSpeed, IsWhereADrySignBuildsUpAndNotAPowersRounding) {
  const auto creeps = [](const char* name) {
    const auto& all = effect_table()[find_effect(name)].parameters;
    return std::ranges::count_if(all, is_creep_speed);
  };
  EXPECT_EQ(creeps("coulomb_friction"), 1);
  EXPECT_EQ(creeps("stribeck_friction"), 1);
  EXPECT_EQ(creeps("power_friction"), 0);
  EXPECT_EQ(creeps("hysteresis_friction"), 0);
}

}  // namespace
}  // namespace lacuna
