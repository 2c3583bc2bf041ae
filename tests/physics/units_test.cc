// Units that follow from what a scenario says of its commands.
#include "physics/units.h"

#include <gtest/gtest.h>

#include "physics/plant_model.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

Scenario driven(std::shared_ptr<const Robot> robot, const std::string& joint, const std::string& model, double gain) {
  std::map<std::string, double> parameters{{"gain", gain}};
  if (model == "torque_source") parameters.insert({{"damping", 1.0}, {"stiffness", 1.0}});
  return bare_scenario(std::move(robot), {actuator(joint, model, parameters)});
}

Scenario pendulum(const std::string& model, double gain) {
  return driven(bundled_robot("pendulum/pendulum.urdf"), "swing", model, gain);
}

std::string unit_of(const Scenario& scenario, const std::string& parameter) {
  const PlantModel model(scenario);
  return model.parameters()[model.find(parameter)].unit;
}

TEST(UnitAt, PutsTheCommandsUnitWhereTheTablesHaveVolts) {
  EXPECT_EQ(unit_at("V", false, "%"), "%");
  EXPECT_EQ(unit_at("V", false, "N m"), "N m");
  EXPECT_EQ(unit_at("N m/V", false, "%"), "N m/%");
  EXPECT_EQ(unit_at("N m/V", true, "A"), "N/A");
  EXPECT_EQ(unit_at("rad/(s V)", true, "A"), "m/(s A)");
  EXPECT_EQ(unit_at("N m/V", false, "N m"), "1");
  EXPECT_EQ(unit_at("N m/V", false, "kg m"), "N m/(kg m)");
  EXPECT_EQ(unit_at("rad/(s V)", false, "l/min"), "rad/(s (l/min))");
  EXPECT_EQ(unit_at("N m s/rad", true, "A"), "N s/m");
  EXPECT_EQ(unit_at("N m", false, "V"), "N m");
}

TEST(CommandUnit, IsTheChannelsElseTheEffortsElseNone) {
  Scenario scenario = pendulum("torque_source", 3.0);
  EXPECT_EQ(command_unit(scenario, "swing"), "cmd") << "no volts unless somebody says so";
  scenario.channels.of[ChannelKind::command]["swing"].unit = "%";
  EXPECT_EQ(command_unit(scenario, "swing"), "%");
  EXPECT_EQ(command_unit(pendulum("direct_effort", 1.0), "swing"), "N m");
  EXPECT_EQ(command_unit(pendulum("direct_effort", 2.0), "swing"), "cmd");
  EXPECT_EQ(command_unit(driven(block_robot(), "slide", "direct_effort", 1.0), "slide"), "N");
  EXPECT_EQ(command_unit(scenario, "nowhere"), "cmd");
}

TEST(PlantModel, CountsWhatHangsOnACommandInItsUnit) {
  Scenario scenario = pendulum("torque_source", 3.0);
  scenario.effects = {effect("valve_deadband", "swing", {{"d", 0.5}})};
  EXPECT_EQ(unit_of(scenario, "swing.gain"), "N m/cmd");
  scenario.channels.of[ChannelKind::command]["swing"].unit = "%";
  EXPECT_EQ(unit_of(scenario, "swing.gain"), "N m/%");
  EXPECT_EQ(unit_of(scenario, "swing.valve_deadband.d"), "%");
  EXPECT_EQ(unit_of(scenario, "swing.damping"), "N m s/rad");
}

}  // namespace
}  // namespace lacuna
