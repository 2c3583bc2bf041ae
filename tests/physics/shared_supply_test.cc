// One pump for two valves that move nothing of each other: speeds against the closed form of a flow that is shared.
#include <gtest/gtest.h>

#include "physics/truth.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kSlideGain = 0.02, kSwingGain = 0.05;  // m/(s V), rad/(s V): of stiff cylinders
constexpr double kSlideFull = 4.0, kSwingFull = 8.0;    // V, command that takes all the pump gives
constexpr double kSharp = 60.0;                         // a corner, but for 1 % at it
constexpr double kSupplySeconds = 2.0, kSupplyPeriod = 0.01;
const Start kStill{{0.0, 0.0}, {0.0, 0.0}};

Scenario two_cylinders(const Drive& drive) {
  const auto cylinder = [](const char* joint, double gain) {  // of 2 kg and .27 kg m^2
    return actuator(joint, "flow_source", {{"gain", gain}, {"stiffness", 4e3}, {"damping", 1e2}});
  };
  return driven_scenario(two_machines().robot, {cylinder("slide", kSlideGain), cylinder("swing", kSwingGain)}, drive,
                         kStill);
}
/// Both valves stepped at once after .1 s.
Drive stepped(double slide, double swing) {
  Drive out = constant_drive(2, kSupplySeconds, kSupplyPeriod, 0.0);
  for (std::size_t k = 10; k < out.time.size(); ++k) out.u[0][k] = slide, out.u[1][k] = swing;
  return out;
}
EffectSpec pump(double sharpness = kSharp) {
  return effect("shared_supply", "arm", {{"full_slide", kSlideFull}, {"full_swing", kSwingFull}, {"n", sharpness}});
}
/// Speeds of slide and swing at the end.
std::pair<double, double> speeds(const Drive& drive, const std::vector<EffectSpec>& effects,
                                 const std::string& engine = "featherstone") {
  const Scenario scenario = two_cylinders(drive);
  const PlantModel model = PlantModel(scenario).with_effects(effects);
  const auto out = predict_one(model, started_experiment(scenario, kStill), on(engine, 0.0025)).front();
  return {out[velocity_of(*scenario.robot, 0)].back(), out[velocity_of(*scenario.robot, 1)].back()};
}

constexpr double kSteady = 2e-3;  // relative: the rod's weight, 4.9 N m/rad, moves in an oil spring of 4,000

TEST(SharedSupply, LeavesAllTheyAskToValvesThatAskLessThanThePumpGives) {
  const auto [slide, swing] = speeds(stepped(1.5, -3.0), {pump()});  // .375 and .375 of the pump
  EXPECT_NEAR(slide, 1.5 * kSlideGain, kSteady * slide);
  EXPECT_NEAR(swing, -3.0 * kSwingGain, kSteady * -swing);
}

TEST(SharedSupply, GivesEachTheSameShareOfWhatItAsksAndAllOfThePumpTogether) {
  const auto [slide, swing] = speeds(stepped(-3.0, 6.0), {pump()});  // .75 and .75 of the pump
  EXPECT_NEAR(slide, -3.0 * kSlideGain / 1.5, kSteady * -slide);
  EXPECT_NEAR(swing, 6.0 * kSwingGain / 1.5, kSteady * swing);
  EXPECT_NEAR(-slide / (kSlideGain * kSlideFull) + swing / (kSwingGain * kSwingFull), 1.0, kSteady);
}

TEST(SharedSupply, LimitsAValveThatIsOpenAloneToo) {
  const auto [slide, swing] = speeds(stepped(10.0, 0.0), {pump()});
  EXPECT_NEAR(slide, kSlideFull * kSlideGain, kSteady * slide);
  EXPECT_NEAR(swing, 0.0, 1e-6);
}

TEST(SharedSupply, IsTheSaturationOfOneValveWhereNoOtherTakesAnything) {
  const Scenario scenario = two_cylinders(stepped(5.0, 0.0));
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStill);
  const auto moved = [&](const EffectSpec& spec) {
    return predict_one(plain.with_effects({spec}), experiment, on("featherstone", 0.0025)).front()[0];
  };
  EXPECT_LT(worst_difference(moved(pump(3.0)),
                             moved(effect("actuator_saturation", "slide", {{"cap", kSlideFull}, {"n", 3.0}}))),
            1e-12);
}

TEST(SharedSupply, AsksWhatComesThroughTheOthersValve) {
  const Drive drive = stepped(3.0, 6.0);
  const EffectSpec overlap =
      effect("valve_deadband", "swing", {{"d", 4.5}});  // lets 1.5 V of 6 through: .19 of the pump
  const auto [slide, swing] = speeds(drive, {overlap, pump()});
  EXPECT_NEAR(slide, 3.0 * kSlideGain, kSteady * slide);
  const EffectSpec closed = effect("valve_deadband", "swing", {{"d", 7.0}});
  EXPECT_NEAR(speeds(stepped(10.0, 6.0), {closed, pump()}).first, kSlideFull * kSlideGain, 1e-3 * kSlideGain);
}

TEST(SharedSupply, TakesOnlyOnceTheOthersValveHasOpened) {
  const Scenario scenario = two_cylinders(stepped(3.0, 6.0));
  const PlantModel model = PlantModel(scenario).with_effects({pump(), effect("input_delay", "swing", {{"T", 0.5}})});
  const auto v = predict_one(model, started_experiment(scenario, kStill), on("featherstone", 0.0025)).front()[2];
  EXPECT_NEAR(v[55], 3.0 * kSlideGain, 1e-2 * v[55]) << "the swing's command is on its way";
  EXPECT_NEAR(v.back(), 3.0 * kSlideGain / 1.5, kSteady * v.back());
}

TEST(SharedSupply, IsAlikeOnEveryEngineAndByAnotherIntegrator) {
  const Drive drive = stepped(-3.0, 6.0);
  const Scenario scenario = two_cylinders(drive);
  const PlantModel model = PlantModel(scenario).with_effects(
      {effect("actuator_lag", "swing", {{"T", 0.15}}), effect("valve_deadband", "slide", {{"d", 0.2}}), pump(8.0)});
  const Experiment experiment = started_experiment(scenario, kStill);
  TruthOptions options;
  options.engine = engine_of_data();
  options.settle = false;
  const auto truth = simulate_truth(model, experiment.segments.front(), experiment.channels, model.values(), options);
  for (const std::string& engine : available_engines()) {
    const auto got = predict_one(model, experiment, on(engine, 0.0025)).front();
    for (const std::size_t joint : {0u, 1u})
      EXPECT_LT(worst_difference(got[joint], truth[joint]), 2e-5) << engine << " " << joint;
  }
}

}  // namespace
}  // namespace lacuna
