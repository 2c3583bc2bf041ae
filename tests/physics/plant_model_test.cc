// The plant's constant model: names, values, and every way in which a scenario can be wrong about them.
#include "physics/plant_model.h"

#include <gtest/gtest.h>

#include "ga/search_space.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

Scenario pendulum_with(std::vector<ActuatorSpec> drives, std::vector<EffectSpec> effects = {}) {
  Scenario scenario = bare_scenario(bundled_robot("pendulum/pendulum.urdf"), std::move(drives));
  scenario.effects = std::move(effects);
  return scenario;
}

ActuatorSpec drive() {
  return actuator("swing", "torque_source", {{"gain", 2.0}, {"damping", 0.5}, {"stiffness", 1.0}});
}

/// All of `parts` stand in the refusal of this scenario, which names the scenario's entry first.
void expect_refused(const Scenario& scenario, const std::string& where, const std::vector<std::string>& parts) {
  const std::string message = input_error([&] { PlantModel model(scenario); });
  EXPECT_EQ(message.rfind(where, 0), 0u) << message;
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
}

TEST(PlantModel, NamesEveryParameterWithItsUnitAndValue) {
  const PlantModel model(
      pendulum_with({drive()}, {effect("coulomb_friction", "swing", {{"Fc", 0.3}}), effect("payload", "arm", {})}));
  const std::vector<std::pair<std::string, double>> expected = {
      {"swing.gain", 2.0},   {"swing.damping", 0.5}, {"swing.stiffness", 1.0},
      {"swing.rest", 0.0},   {"rod.mass", 1.0},      {"swing.coulomb_friction.Fc", 0.3},
      {"arm.payload.m", 0.0}};
  for (const auto& [name, value] : expected) {
    const int index = model.find(name);
    ASSERT_GE(index, 0) << name;
    EXPECT_EQ(model.values()[index], value) << name;
  }
  EXPECT_EQ(model.parameters()[model.find("swing.gain")].unit, "N m/cmd");
  EXPECT_EQ(model.find("swing.nothing"), -1);
  EXPECT_EQ(model.matching("damping"), std::vector<int>{model.find("swing.damping")});
  EXPECT_EQ(model.matching("mass"), std::vector<int>{model.find("rod.mass")});
  EXPECT_TRUE(model.matching("nothing").empty());
}

TEST(PlantModel, GivesLinearUnitsToPrismaticJoints) {
  const PlantModel model(bare_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}})}));
  EXPECT_EQ(model.parameters()[model.find("slide.damping")].unit, "N s/m");
  const PlantModel more =
      model.with_effects({effect("power_friction", "slide", {}), effect("gear_ripple", "slide", {}),
                          effect("viscous_friction", "slide", {}), effect("torque_offset", "slide", {})});
  const std::vector<std::pair<std::string, std::string>> units = {
      {"power_friction.c", "N (s/m)^p"}, {"power_friction.v0", "m/s"}, {"gear_ripple.n", "1/m"}, {"gear_ripple.a", "N"},
      {"viscous_friction.D", "N s/m"},   {"torque_offset.tau0", "N"}};
  for (const auto& [name, unit] : units) EXPECT_EQ(more.parameters()[more.find("slide." + name)].unit, unit) << name;
}

TEST(PlantModel, RefusesWhatItDoesNotKnowAndListsWhatItDoes) {
  const std::string at = "test: actuators.swing";
  expect_refused(pendulum_with({actuator("swing", "magnet", {})}), at,
                 {"\"magnet\"", "torque_source", "flow_source", "direct_effort", "hydraulic"});
  expect_refused(pendulum_with({actuator("swing", "torque_source", {{"gian", 1.0}})}), at,
                 {"\"gian\"", "gain", "damping"});
  expect_refused(pendulum_with({drive()}, {effect("gremlins", "swing", {})}), "test: effects",
                 {"\"gremlins\"", "coulomb_friction", "payload"});
  expect_refused(pendulum_with({drive()}, {effect("coulomb_friction", "swing", {{"mu", 1.0}})}), "test: effects",
                 {"\"mu\"", "Fc"});
}

TEST(PlantModel, RefusesMissingAndImpossibleValuesWithTheAllowedRange) {
  expect_refused(pendulum_with({actuator("swing", "torque_source", {{"gain", 1.0}})}), "test: actuators.swing",
                 {"damping"});
  expect_refused(
      pendulum_with({actuator("swing", "torque_source", {{"gain", 1.0}, {"damping", -1.0}, {"stiffness", 1.0}})}),
      "test: actuators.swing", {"damping = -1", "0"});
  expect_refused(pendulum_with({drive()}, {effect("input_delay", "swing", {{"T", 5.0}})}), "test: effects",
                 {"T = 5", "1 s"});
  expect_refused(pendulum_with({drive()}, {effect("coulomb_friction", "swing", {{"Fc", kMissing}})}), "test: effects",
                 {"Fc"});
}

TEST(PlantModel, RefusesABreakAwayEffortBelowTheSlidingOne) {
  expect_refused(pendulum_with({drive()}, {effect("stribeck_friction", "swing", {{"Fc", 2.0}, {"Fs", 1.0}})}),
                 "test: effects", {"Fs = 1 N m", "at least Fc = 2 N m"});
  expect_refused(pendulum_with({drive()}, {effect("stribeck_friction", "swing", {{"Fc", 2.0}})}), "test: effects",
                 {"Fs = 0 N m", "at least Fc = 2 N m"});
  const PlantModel equal(pendulum_with({drive()}, {effect("stribeck_friction", "swing", {{"Fc", 2.0}, {"Fs", 2.0}})}));
  EXPECT_GE(equal.find("swing.stribeck_friction.Fs"), 0);
}

TEST(PlantModel, TakesNegativeGainsAndOrdersTheBoundsRelativeToThem) {
  for (const ActuatorInfo& info : actuator_table()) {
    std::map<std::string, double> p{{"gain", -2.0}};
    for (const ParameterInfo& needed : info.parameters)
      if (std::isnan(needed.neutral)) p.try_emplace(needed.name, std::clamp(1.0, needed.lower, needed.upper));
    Scenario scenario = pendulum_with({actuator("swing", info.name, p)});
    scenario.identify = {{"gain", true, 0.5, 2.0, "test"}};
    const PlantModel model(scenario);
    EXPECT_EQ(model.values()[model.find("swing.gain")], -2.0) << info.name;
    const SearchSpace space(model, scenario);
    ASSERT_EQ(space.size(), 1u);
    EXPECT_EQ(space.axes()[0].lower, -4.0) << info.name;
    EXPECT_EQ(space.axes()[0].upper, -1.0) << info.name;
  }
}

/// A boom and an arm, as an excavator's: the second joint is named as the whole arm is.
Scenario excavator(std::vector<EffectSpec> effects) {
  const std::string link =
      "<inertial><origin xyz='0.5 0 0'/><mass value='2'/><inertia ixx='0.1' iyy='0.2' izz='0.2' ixy='0' ixz='0' "
      "iyz='0'/></inertial>";
  const auto joint = [](const std::string& name, const std::string& from, const std::string& to) {
    return "<joint name='" + name + "' type='continuous'><origin xyz='1 0 0'/><parent link='" + from +
           "'/><child link='" + to + "'/><axis xyz='0 1 0'/></joint>";
  };
  Scenario scenario =
      bare_scenario(Robot::from_urdf_text("<robot name='excavator'><link name='base'/><link name='one'>" + link +
                                              "</link><link name='two'>" + link + "</link>" +
                                              joint("boom", "base", "one") + joint("arm", "one", "two") + "</robot>",
                                          "excavator"),
                    {actuator("arm", "torque_source", {{"gain", 2.0}, {"damping", 0.5}, {"stiffness", 1.0}})});
  scenario.effects = std::move(effects);
  return scenario;
}

TEST(PlantModel, TellsAJointNamedArmFromTheWholeArm) {
  const PlantModel model(
      excavator({effect("payload", "arm", {{"m", 3.0}}), effect("coulomb_friction", "arm", {{"Fc", 0.7}}),
                 effect("supply_pressure_sag", "arm", {{"depth", 0.1}, {"flow_arm", 2.0}})}));
  EXPECT_EQ(model.effects()[model.find_effect_at("payload", "arm")].joint, -1);
  EXPECT_EQ(model.effects()[model.find_effect_at("coulomb_friction", "arm")].joint, 1);
  EXPECT_EQ(model.find_effect_at("coulomb_friction", "boom"), -1);
  for (const Component& effect : model.effects()) EXPECT_EQ(model.place_name(effect), "arm");
  const std::vector<std::pair<std::string, double>> expected = {{"arm.gain", 2.0},
                                                                {"arm.payload.m", 3.0},
                                                                {"arm.coulomb_friction.Fc", 0.7},
                                                                {"arm.supply_pressure_sag.flow_arm", 2.0}};
  for (const auto& [name, value] : expected) {
    ASSERT_GE(model.find(name), 0) << name;
    EXPECT_EQ(model.values()[model.find(name)], value) << name;
    EXPECT_EQ(model.matching(name), std::vector<int>{model.find(name)});
  }
  EXPECT_EQ(model.matching("gain"), std::vector<int>{model.find("arm.gain")});
  EXPECT_EQ(model.matching("payload.m"), std::vector<int>{model.find("arm.payload.m")});
}

TEST(PlantModel, LetsNoJointNamedArmStandForTheWholeArmTwice) {
  const PlantModel plain(excavator({}));
  const PlantModel joint = plain.with_effects({effect("armature", "arm", {{"J", 0.3}})});
  EXPECT_EQ(joint.armatures(joint.values()), (std::vector<double>{0.0, 0.3}));
  expect_refused(excavator({effect("armature", "arm", {}), effect("armature", "arm", {})}), "test: effects", {"twice"});
  expect_refused(excavator({effect("payload", "boom", {})}), "test: effects", {"\"boom\"", "arm"});
  const PlantModel carrying = plain.with_effects({effect("payload", "arm", {{"m", 3.0}})});
  EXPECT_NEAR(carrying.inertials(carrying.values())[1].mass, 5.0, 1e-14);
}

TEST(PlantModel, RefusesEffectsAtAPlaceWhereTheyCannotActOrStandAlready) {
  expect_refused(pendulum_with({drive()}, {effect("coulomb_friction", "arm", {})}), "test: effects",
                 {"\"arm\"", "joint"});
  expect_refused(pendulum_with({drive()}, {effect("payload", "swing", {})}), "test: effects", {"\"swing\"", "arm"});
  expect_refused(pendulum_with({drive()}, {effect("coulomb_friction", "elbow", {})}), "test: effects", {"\"elbow\""});
  expect_refused(pendulum_with({drive()}, {effect("payload", "arm", {}), effect("payload", "arm", {})}),
                 "test: effects", {"twice"});
}

TEST(PlantModel, SwitchesAnEffectOffInRecordingsThatItDoesNotName) {
  const PlantModel model(pendulum_with({drive()}, {effect("payload", "arm", {{"m", 2.0}}, {"a.csv", "b.csv"})}));
  const std::size_t m = model.find("arm.payload.m");
  EXPECT_EQ(model.values_in("a.csv", model.values())[m], 2.0);
  EXPECT_EQ(model.values_in("b.csv", model.values())[m], 2.0);
  EXPECT_EQ(model.values_in("c.csv", model.values())[m], 0.0);
}

TEST(PlantModel, SaysWhichEffectsDoNothingAsTheyAreGiven) {
  Scenario scenario = pendulum_with(
      {drive()}, {effect("end_stop", "swing", {{"q_lim", 0.5}}), effect("coulomb_friction", "swing", {{"Fc", 1.0}})});
  const std::vector<std::string> idle = idle_effects(scenario);
  ASSERT_EQ(idle.size(), 1u);
  EXPECT_NE(idle.front().find("end_stop at swing does nothing: k = 0"), std::string::npos) << idle.front();
  scenario.identify = {{"swing.end_stop.k", false, 0.0, 1e4, "test"}};
  EXPECT_TRUE(idle_effects(scenario).empty()) << "it is searched from there";
}

TEST(PlantModel, WithEffectsLeavesTheOriginalAndTheOldValuesAlone) {
  const PlantModel plain(pendulum_with({drive()}));
  const PlantModel more = plain.with_effects({effect("valve_offset", "swing", {{"b", 0.1}})});
  EXPECT_EQ(plain.find("swing.valve_offset.b"), -1);
  ASSERT_GT(more.parameters().size(), plain.parameters().size());
  for (std::size_t i = 0; i < plain.parameters().size(); ++i)
    EXPECT_EQ(more.parameters()[i].name, plain.parameters()[i].name);
  EXPECT_EQ(more.find_effect_at("valve_offset", "swing"), 0);
  EXPECT_EQ(more.find_effect_at("valve_offset", "arm"), -1);
}

TEST(PlantModel, ScalesALinksInertiaWithItsMass) {
  const PlantModel model(pendulum_with({drive()}));
  std::vector<double> values = model.values();
  values[model.find("rod.mass")] = 3.0;
  const Inertial one = model.inertials(model.values())[0], three = model.inertials(values)[0];
  EXPECT_DOUBLE_EQ(three.mass, 3.0 * one.mass);
  EXPECT_TRUE(three.com.isApprox(one.com, 1e-14));
  EXPECT_TRUE(three.inertia.isApprox(3.0 * one.inertia, 1e-14));
}

}  // namespace
}  // namespace lacuna
