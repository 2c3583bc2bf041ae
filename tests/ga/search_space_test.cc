#include "ga/search_space.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

IdentifySpec relative(const std::string& name, double lower, double upper) {
  return {name, true, lower, upper, "test: identify." + name};
}
IdentifySpec absolute(const std::string& name, double lower, double upper) {
  return {name, false, lower, upper, "test: identify." + name};
}

Scenario arm(std::vector<IdentifySpec> identify) {
  Scenario scenario =
      bare_scenario(bundled_robot("hydrolek/seed_table1.urdf"),
                    {actuator("joint_2", "torque_source",
                              {{"gain", 100.0}, {"damping", 50.0}, {"stiffness", 1000.0}, {"rest", 0.0}})});
  scenario.identify = std::move(identify);
  return scenario;
}

double moving(const PlantModel& model, const std::vector<double>& values) {
  const std::vector<double> masses = model.link_masses(values);
  return std::accumulate(masses.begin(), masses.end(), 0.0);
}

TEST(SearchSpace, TakesBoundsRelativeToTheStartOrAbsolute) {
  const Scenario scenario = arm({relative("gain", 0.5, 3.0), absolute("joint_2.damping", 10.0, 60.0)});
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario);
  ASSERT_EQ(space.size(), 2u);
  EXPECT_DOUBLE_EQ(space.axes()[0].lower, 50.0);
  EXPECT_DOUBLE_EQ(space.axes()[0].upper, 300.0);
  EXPECT_EQ(space.axes()[1].lower, 10.0);
  EXPECT_EQ(space.axes()[1].upper, 60.0);
  EXPECT_EQ(space.start(), (std::vector<double>{100.0, 50.0}));
  EXPECT_EQ(space.box(model).names, (std::vector<std::string>{"joint_2.gain", "joint_2.damping"}));
}

TEST(SearchSpace, LetsAFullNameRefineItsKindInEitherOrder) {
  for (const bool kind_first : {true, false}) {
    std::vector<IdentifySpec> specs{relative("mass", 0.5, 2.0), absolute("link_3.mass", 1.0, 30.0)};
    if (!kind_first) std::swap(specs[0], specs[1]);
    const Scenario scenario = arm(specs);
    const PlantModel model(scenario);
    const SearchSpace space(model, scenario);
    EXPECT_EQ(space.size(), 6u);
    for (const Axis& axis : space.axes()) {
      if (axis.parameter == model.find("link_3.mass")) {
        EXPECT_EQ(axis.upper, 30.0) << kind_first;
      }
    }
  }
}

TEST(SearchSpace, ExpandPutsThePointInAndLeavesTheRest) {
  const Scenario scenario = arm({relative("gain", 0.5, 3.0)});
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario);
  std::vector<double> expected = model.values();
  expected[model.find("joint_2.gain")] = 123.0;
  EXPECT_EQ(space.expand(std::vector<double>{123.0}), expected);
  EXPECT_EQ(space.contract(expected), std::vector<double>{123.0});
}

TEST(SearchSpace, SearchesACapByItsInverse) {
  Scenario scenario = arm({absolute("joint_2.actuator_saturation.cap", 2.0, 10.0)});
  scenario.effects = {effect("actuator_saturation", "joint_2", {{"cap", 4.0}})};
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario);
  EXPECT_DOUBLE_EQ(space.axes()[0].lower, 0.1);
  EXPECT_DOUBLE_EQ(space.axes()[0].upper, 0.5);
  EXPECT_DOUBLE_EQ(space.expand(std::vector<double>{0.2})[space.axes()[0].parameter], 5.0);
}

TEST(SearchSpace, HonoursAKnownTotalMassAtEveryPointOfTheBox) {
  Scenario scenario = arm({relative("mass", 0.2, 3.0)});
  scenario.total_mass = 45.0;
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario);
  ASSERT_EQ(space.size(), 5u) << "the heaviest mass is no axis";
  EXPECT_EQ(space.dependent(), model.find("link_3.mass"));
  Noise random(1);
  for (int k = 0; k < 500; ++k) {
    std::vector<double> point;
    for (const Axis& axis : space.axes()) {
      // Corners too: there the dependent mass is at its bounds.
      const double share = k % 3 == 0 ? std::round(random.uniform()) : random.uniform();
      point.push_back(axis.lower + share * (axis.upper - axis.lower));
    }
    const std::vector<double> values = space.expand(point);
    EXPECT_NEAR(moving(model, values), 45.0, 45.0 * 1e-14) << k;
    for (const double mass : model.link_masses(values)) EXPECT_GE(mass, 0.0);
  }
}

TEST(SearchSpace, CountsMassesThatAreNotSearchedInTheTotal) {
  Scenario scenario = arm({relative("link_2.mass", 0.2, 3.0), relative("link_3.mass", 0.2, 3.0)});
  const PlantModel model(scenario);
  scenario.total_mass = moving(model, model.values()) + 1.5;
  const SearchSpace space(model, scenario);
  EXPECT_NEAR(moving(model, space.expand(space.start())), *scenario.total_mass, 1e-12);
}

TEST(SearchSpace, RefusesWhatCannotBeSearched) {
  auto refusal = [](Scenario scenario) {
    const PlantModel model(scenario);
    return input_error([&] { SearchSpace space(model, scenario); });
  };
  EXPECT_NE(refusal(arm({relative("colour", 0.5, 2.0)})).find("\"colour\""), std::string::npos);
  EXPECT_NE(refusal(arm({absolute("joint_2.gain", 1.0, 50.0)})).find("outside its bounds"), std::string::npos);
  EXPECT_NE(refusal(arm({relative("joint_2.rest", 0.5, 2.0)})).find("relative bounds"), std::string::npos);
  Scenario heavy = arm({relative("mass", 0.5, 2.0)});
  heavy.total_mass = 500.0;
  EXPECT_NE(refusal(heavy).find("total_mass"), std::string::npos);
  EXPECT_EQ(refusal(arm({relative("gain", 0.5, 2.0)})), "");
}

Scenario signed_arm(double gain) {
  Scenario scenario = arm({relative("gain", 0.5, 3.0), relative("damping", 0.25, 4.0), absolute("rest", -1.0, 1.0)});
  scenario.actuators.front().parameters["gain"] = gain;
  return scenario;
}

TEST(SearchSpace, SearchesWhatKeepsItsSignAsARatioToItsStartWithAPrior) {
  const Scenario scenario = signed_arm(100.0);
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario, Coordinates::ratios);
  ASSERT_EQ(space.size(), 3u);
  EXPECT_EQ(space.start(), (std::vector<double>{0.0, 0.0, 0.0}));
  EXPECT_EQ(space.expand(space.start()), model.values());
  EXPECT_NEAR(space.axes()[0].lower, std::log(0.5), 1e-15);
  EXPECT_NEAR(space.axes()[0].upper, std::log(3.0), 1e-15);
  EXPECT_NEAR(space.axes()[1].prior, std::log(2.0), 1e-15) << "[1/4, 4]: two standard deviations either way";
  EXPECT_EQ(space.axes()[2].coordinate, Coordinate::linear) << "a position may change its sign";
  EXPECT_EQ(space.axes()[2].prior, 0.5);
  const std::vector<double> values = space.expand(std::vector<double>{std::log(2.0), 0.0, 0.25});
  EXPECT_NEAR(values[model.find("joint_2.gain")], 200.0, 1e-12);
  EXPECT_EQ(values[model.find("joint_2.rest")], 0.25);
  EXPECT_NEAR(space.contract(values)[0], std::log(2.0), 1e-15);
}

TEST(SearchSpace, SharesAKnownTotalAmongAllMassesWithinTheirBounds) {
  Scenario scenario = arm({relative("mass", 0.4, 2.5)});
  scenario.total_mass = 45.0;
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario, Coordinates::ratios);
  ASSERT_EQ(space.size(), 5u);
  ASSERT_EQ(space.shared_masses().size(), 6u);
  EXPECT_EQ(space.dependent(), model.find("link_3.mass"));
  const double before = moving(model, model.values());
  for (const SharedMass& mass : space.shared_masses()) {
    EXPECT_NEAR(space.expand(space.start())[mass.parameter], mass.start * 45.0 / before, 1e-12);
  }
  Noise random(1);
  for (int k = 0; k < 500; ++k) {
    std::vector<double> point;
    for (const Axis& axis : space.axes()) {
      const double share = k % 3 == 0 ? std::round(random.uniform()) : random.uniform();
      point.push_back(axis.lower + share * (axis.upper - axis.lower));
    }
    const std::vector<double> values = space.expand(point);
    EXPECT_NEAR(moving(model, values), 45.0, 45.0 * 1e-14) << k;
    bool inside = true;
    for (const SharedMass& mass : space.shared_masses()) {
      const double value = values[mass.parameter];
      EXPECT_GE(value, mass.lower * (1.0 - 1e-14)) << k;
      EXPECT_LE(value, mass.upper * (1.0 + 1e-14)) << k;
      inside = inside && value > mass.lower && value < mass.upper;
    }
    const std::vector<double> again = space.contract(values);
    for (std::size_t a = 0; inside && a < again.size(); ++a) EXPECT_NEAR(again[a], point[a], 1e-12) << k;
  }
}

TEST(SearchSpace, CutsAnAddedAxisToTheParametersPhysicalRange) {
  Scenario scenario = arm({relative("gain", 0.5, 2.0)});
  const PlantModel plain(scenario);
  SearchSpace space(plain, scenario);
  const PlantModel more = plain.with_effects({effect("coulomb_friction", "joint_2", {})});
  space.add(more, {more.find("joint_2.coulomb_friction.Fc"), -5.0, 7.0, -2.0, Coordinate::linear});
  EXPECT_EQ(space.axes().back().lower, 0.0);
  EXPECT_EQ(space.axes().back().start, 0.0);
  const std::vector<double> values = space.expand(std::vector<double>{100.0, 3.0});
  ASSERT_EQ(values.size(), more.parameters().size());
  EXPECT_EQ(values[more.find("joint_2.coulomb_friction.Fc")], 3.0);
}

}  // namespace
}  // namespace lacuna
