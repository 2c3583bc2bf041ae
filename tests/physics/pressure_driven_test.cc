// Joints that their measured pressures push: against closed forms, and against the motion that the valve brought.
#include <gtest/gtest.h>

#include "ga/search_space.h"
#include "tests/physics/hydraulic_plants.h"

namespace lacuna {
namespace {

using namespace test;
using namespace test::hydraulic;

const Start kPistonAtRest{{0.0}, {0.0}};
constexpr double kPressureRounding = 1e-10;  // m, of what RK4 follows exactly

std::vector<double> position(const Scenario& scenario, const std::string& engine = "featherstone",
                             double step = kStep) {
  return predict_one(PlantModel(scenario), started_experiment(scenario, kPistonAtRest), on(engine, step))
      .front()
      .front();
}
constexpr double kHead = 20 * kBar, kRod = 10 * kBar;
double constant_head(double) { return kHead; }
double constant_rod(double) { return kRod; }

TEST(PressureDriven, ConstantPressuresAccelerateABlockEvenlyOnEveryEngine) {
  const Scenario scenario = pressed(block_robot(), symmetric(), constant_head, constant_rod);
  const double a = (kHead - kRod) * kArea / kBlockMass;
  for (const std::string& engine : available_engines()) {
    const std::vector<double> q = position(scenario, engine);
    for (std::size_t k = 0; k < q.size(); ++k) {
      const double t = 0.01 * static_cast<double>(k);
      ASSERT_NEAR(q[k], 0.5 * a * t * t, 1e-9 * a) << engine << " at " << t;
    }
  }
}

TEST(PressureDriven, PressuresGoOnStraightLinesBetweenSamples) {
  constexpr double kRise = 50 * kBar;  // Pa/s
  const auto rising = [](double t) { return kRod + kRise * t; };
  const std::vector<double> q = position(pressed(block_robot(), symmetric(), rising, constant_rod));
  for (std::size_t k = 0; k < q.size(); ++k) {
    const double t = 0.01 * static_cast<double>(k);
    ASSERT_NEAR(q[k], kRise * kArea / kBlockMass * t * t * t / 6.0, kPressureRounding) << t;
  }
}

TEST(PressureDriven, NothingThatFillsTheChambersMatters) {
  const auto with_numbers = [](const Numbers& changed) {
    return position(pressed(rotor(), with(with(cylinder(), kLever), changed), constant_head, constant_rod));
  };
  const auto q = with_numbers({});
  EXPECT_GT(*std::ranges::max_element(q), 0.1);
  EXPECT_EQ(q, with_numbers({{"gain", 1e-8}, {"bulk_modulus", 3e8}, {"supply_pressure", 90 * kBar}, {"stroke", 0.3}}));
  EXPECT_NE(q, with_numbers({{"area_a", 1.3e-3}}));
  EXPECT_NE(q, with_numbers({{"lever_b", 0.080}}));
}

/// A rotor that a valve moves against friction, and the same as its recorded pressures move it.
struct Twice {
  Moved by_valve;
  Scenario by_pressures;
  explicit Twice(double sample) {
    const Scenario valve = driven(rotor(), with(cylinder(), kLever), sine_drive(1, 2.0, sample, 8.0), kPistonAtRest,
                                  {effect("coulomb_friction", "swing", {{"Fc", 5.0}})});
    by_valve = simulated(valve, kPistonAtRest, 1e-3);
    auto data = std::make_shared<Recording>(*valve.recordings[0].data);
    data->columns[data->find("a_swing")] = by_valve.a();
    data->columns[data->find("b_swing")] = by_valve.b();
    by_pressures = valve;
    by_pressures.recordings[0].data = data;
    by_pressures.pressure_driven = true;
  }
  double differ(const std::string& engine) const {
    return worst_difference(position(by_pressures, engine, 1e-3), by_valve.q());
  }
};

TEST(PressureDriven, MovesAsTheValveMovedItTheBetterTheFinerItIsSampled) {
  const Twice coarse(1e-3), fine(2.5e-4);
  const auto [low, high] = std::minmax_element(fine.by_valve.q().begin(), fine.by_valve.q().end());
  ASSERT_GT(*high - *low, 0.05);
  for (const std::string& engine : available_engines()) {
    EXPECT_LT(coarse.differ(engine), 1e-2 * (*high - *low)) << engine;
    EXPECT_LT(fine.differ(engine), 1e-3 * (*high - *low)) << engine;
  }
  Scenario smooth = fine.by_pressures;
  smooth.effects.clear();
  EXPECT_GT(worst_difference(position(smooth), fine.by_valve.q()), 0.01)
      << "without friction the same pressures move it on";
}

TEST(PressureDriven, MeetsAnIndependentIntegrator) {
  const Twice twice(1e-3);
  const PlantModel model(twice.by_pressures);
  const Experiment experiment = started_experiment(twice.by_pressures, kPistonAtRest);
  const auto reference = reference_of(model, experiment);
  EXPECT_LT(worst_difference(position(twice.by_pressures, "featherstone", 1e-3), reference.front()), 1e-7);
}

TEST(PressureDriven, ComparesNoPressureAndCommandsNothing) {
  const Experiment experiment = make_experiment(pressed(block_robot(), symmetric(), constant_head, constant_rod));
  for (const Channel& channel : experiment.channels) {
    EXPECT_NE(channel.kind, ChannelKind::pressure_a);
    EXPECT_NE(channel.kind, ChannelKind::pressure_b);
  }
  EXPECT_EQ(experiment.command_rms[0], 0.0);
  EXPECT_NEAR(experiment.effort_rms[0], (kHead - kRod) * kArea, 1e-9);
}

TEST(PressureDriven, SaysWhichEffectsStandBeforeThePressures) {
  Scenario scenario =
      pressed(block_robot(), symmetric(), constant_head, constant_rod,
              {effect("valve_deadband", "slide", {{"d", 1.0}}), effect("coulomb_friction", "slide", {{"Fc", 1.0}})});
  const std::vector<std::string> idle = idle_effects(scenario);
  ASSERT_EQ(idle.size(), 1u);
  EXPECT_NE(idle.front().find("valve_deadband at slide does nothing: measured pressures"), std::string::npos)
      << idle.front();
  scenario.pressure_driven = false;
  EXPECT_TRUE(idle_effects(scenario).empty());
}

TEST(PressureDriven, RefusesAPressureThatIsMissingAndNumbersThatDoNothing) {
  Scenario scenario = pressed(
      block_robot(), symmetric(), [](double t) { return t > 0.495 && t < 0.505 ? kMissing : kHead; }, constant_rod);
  const std::string missing = input_error([&] { make_experiment(scenario); });
  EXPECT_NE(missing.find("pressure_a"), std::string::npos) << missing;
  EXPECT_NE(missing.find("0.5 s"), std::string::npos) << missing;
  scenario = pressed(block_robot(), symmetric(), constant_head, constant_rod);
  scenario.identify = {{"slide.area_a", true, 0.5, 2.0, "test: identify"}};
  EXPECT_EQ(SearchSpace(PlantModel(scenario), scenario).size(), 1u);
  scenario.identify.push_back({"slide.gain", true, 0.5, 2.0, "test: identify"});
  const std::string idle = input_error([&] { SearchSpace(PlantModel(scenario), scenario); });
  EXPECT_NE(idle.find("slide.gain"), std::string::npos) << idle;
}

}  // namespace
}  // namespace lacuna
