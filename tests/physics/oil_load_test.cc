// What the load does to a drive that integrates its flow: speeds against the closed forms of steady motion.
#include <gtest/gtest.h>

#include <numbers>

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
constexpr double kMost = 40.0;                        // N, at which the relief valves open
constexpr double kHalfStroke = 0.5;                   // m
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
EffectSpec relief() { return effect("relief", "slide", {{"most", kMost}}); }
EffectSpec soft_oil() { return effect("oil_compressibility", "slide", {{"half", kHalfStroke}}); }

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

TEST(Relief, IsNothingUpToTheLoadAtWhichItOpens) {
  EXPECT_EQ(steady_speed(1.0, 0.9 * kMost, relief()), steady_speed(1.0, 0.9 * kMost, effect("relief", "slide", {})));
}

TEST(Relief, LetsPassWhatIsBeyondItsLoad) {
  constexpr double kPass = 1e-3 * kLoadSpring;  // N s/m: the oil that is too much leaves within 1 ms
  EXPECT_NEAR(steady_speed(1.0, kLoad, relief()), kLoadedSpeed - (kLoad - kMost) / kPass, kSpeedRounding);
  EXPECT_NEAR(steady_speed(0.0, -kLoad, relief()), (kLoad - kMost) / kPass, kSpeedRounding);
}

/// How far the block is from `at`, valve shut, after swinging freely on undamped oil for `seconds` from a push there.
double swung(double at, double seconds, double push, const std::string& engine) {
  const Start start{{at}, {push}};
  const Scenario scenario = driven_scenario(
      block_robot(),
      {actuator("slide", "flow_source", {{"gain", kLoadedSpeed}, {"stiffness", kLoadSpring}, {"damping", 0.0}})},
      constant_drive(1, seconds, seconds / 50.0, 0.0), start);
  const PlantModel model = PlantModel(scenario).with_effects({soft_oil()});
  return predict_one(model, started_experiment(scenario, start), on(engine, 1e-4)).front()[0].back() - at;
}

TEST(OilCompressibility, IsASpringThatIsStifferTowardsTheEndsOfTheStroke) {
  constexpr double kFirstSpeed = 0.01;  // m/s: within a tenth of a millimetre the spring stays the same
  for (const std::string& engine : available_engines()) {
    for (const double share : {0.0, -0.5, 0.8}) {
      const double omega = std::sqrt(kLoadSpring / (1.0 - share * share) / kBlockMass);
      const double quarter = 0.5 * std::numbers::pi / omega;
      EXPECT_NEAR(swung(share * kHalfStroke, quarter, kFirstSpeed, engine), kFirstSpeed / omega,
                  2e-3 * kFirstSpeed / omega)
          << engine;
      EXPECT_NEAR(swung(share * kHalfStroke, 4.0 * quarter, kFirstSpeed, engine), 0.0, 1e-2 * kFirstSpeed / omega)
          << engine;
    }
  }
}

TEST(OilCompressibility, ChangesNoSteadySpeed) {
  EXPECT_NEAR(steady_speed(0.5, kLoad, soft_oil()), 0.5 * kLoadedSpeed, 1e-4 * kLoadedSpeed);
}

TEST(OilLoad, IsAlikeOnEveryEngine) {
  for (const std::string& engine : available_engines()) {
    EXPECT_NEAR(steady_speed(1.0, kLoad, orifice(), engine), steady_speed(1.0, kLoad, orifice()), kSpeedRounding)
        << engine;
    for (const EffectSpec& spec : {leak(), relief()})
      EXPECT_NEAR(steady_speed(0.0, kLoad, spec, engine), steady_speed(0.0, kLoad, spec), kSpeedRounding) << engine;
  }
}

TEST(OilLoad, IsRefusedWhereTheDriveIntegratesNoFlow) {
  for (const EffectSpec& spec : {orifice(), leak(), relief(), soft_oil()}) {
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
