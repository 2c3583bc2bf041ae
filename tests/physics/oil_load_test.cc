// What the load does to a drive that integrates its flow: speeds against the closed forms of steady motion.
#include <gtest/gtest.h>

#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kLoadedSpeed = 0.2;                  // m/s under 1 V
constexpr double kLoadSpring = 2e4, kLoadLoss = 6e2;  // N/m, N s/m, of the oil
constexpr double kLoad = 50.0;                        // N, against the positive way
constexpr double kStall = 80.0;                       // N
constexpr double kLeak = 1e3;                         // N s/m
constexpr double kSpeedRounding = 1e-6;               // m/s, of what is left of the start's swing after 2 s
const Start kFree{{0.0}, {0.0}};

/// Speed at the end of 2 s under one command and one load, with that effect.
double steady_speed(double command, double load, const EffectSpec& spec, const std::string& engine = "featherstone") {
  const Scenario scenario = driven_scenario(
      block_robot(),
      {actuator("slide", "flow_source", {{"gain", kLoadedSpeed}, {"stiffness", kLoadSpring}, {"damping", kLoadLoss}})},
      constant_drive(1, 2.0, 0.01, command), kFree);
  const PlantModel model =
      PlantModel(scenario).with_effects({effect("torque_offset", "slide", {{"tau0", -load}}), spec});
  return predict_one(model, started_experiment(scenario, kFree), on(engine, 1e-3))
      .front()[velocity_of(*scenario.robot, 0)]
      .back();
}
EffectSpec orifice() { return effect("orifice_load_dependence", "slide", {{"stall", kStall}}); }
EffectSpec leak() { return effect("leakage", "slide", {{"R", kLeak}}); }

/// sqrt(1 - share), where the laminar range about 0, a hundredth of the supply's pressure, takes a share of 1e-4/4.
constexpr double kRoot = 1e-3;

TEST(OrificeLoadDependence, IsSlowerAgainstTheLoadAndFasterWithItByTheRootOfThePressureLeft) {
  EXPECT_NEAR(steady_speed(1.0, kLoad, orifice()), kLoadedSpeed * std::sqrt(1.0 - kLoad / kStall),
              kRoot * kLoadedSpeed);
  EXPECT_NEAR(steady_speed(-1.0, kLoad, orifice()), -kLoadedSpeed * std::sqrt(1.0 + kLoad / kStall),
              kRoot * kLoadedSpeed);
  EXPECT_NEAR(steady_speed(1.0, 0.0, orifice()), kLoadedSpeed, kSpeedRounding);
}

TEST(OrificeLoadDependence, StandsUnderALoadThatTakesAllOfTheSupplysPressure) {
  EXPECT_NEAR(steady_speed(1.0, kStall, orifice()), 0.0, kRoot * kLoadedSpeed);
}

TEST(Leakage, LetsALoadSinkAtRestAndSlowsItsLiftingAsMuch) {
  EXPECT_NEAR(steady_speed(0.0, kLoad, leak()), -kLoad / kLeak, kSpeedRounding);
  EXPECT_NEAR(steady_speed(1.0, kLoad, leak()), kLoadedSpeed - kLoad / kLeak, kSpeedRounding);
  EXPECT_NEAR(steady_speed(1.0, 0.0, leak()), kLoadedSpeed, kSpeedRounding);
}

TEST(OilLoad, IsAlikeOnEveryEngine) {
  for (const std::string& engine : available_engines()) {
    EXPECT_NEAR(steady_speed(1.0, kLoad, orifice(), engine), steady_speed(1.0, kLoad, orifice()), kSpeedRounding)
        << engine;
    EXPECT_NEAR(steady_speed(0.0, kLoad, leak(), engine), steady_speed(0.0, kLoad, leak()), kSpeedRounding) << engine;
  }
}

TEST(OilLoad, IsRefusedWhereTheDriveIntegratesNoFlow) {
  for (const EffectSpec& spec : {orifice(), leak()}) {
    Scenario scenario = driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}})},
                                        constant_drive(1, 1.0, 0.01, 0.0), kFree);
    scenario.effects = {spec};
    const std::string error = input_error([&] { PlantModel model(scenario); });
    EXPECT_NE(error.find(spec.effect), std::string::npos) << error;
    EXPECT_NE(error.find("slide"), std::string::npos) << error;
    EXPECT_NE(error.find("flow_source"), std::string::npos) << error;
  }
}

}  // namespace
}  // namespace lacuna
