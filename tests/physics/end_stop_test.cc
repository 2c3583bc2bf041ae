// A cylinder between its two stops: where it ends, and that it leaves them at once when its flow is turned.
#include <gtest/gtest.h>

#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kOilSpeed = 0.2;            // m/s under 1 V
constexpr double kTop = 0.3, kTravel = 0.5;  // m
constexpr double kOilSpring = 2e4,
                 kOilLoss = 6e2;                 // N/m, N s/m, of the oil: a block of some kg swings at 14 Hz, damped
constexpr double kContact = 2e5, kDamp = 0.005;  // N/m, s
const Start kAtRest{{0.0}, {0.0}};

EffectSpec stops(double k, double q_lim, double travel) {
  return effect("end_stop", "slide", {{"k", k}, {"q_lim", q_lim}, {"T", kDamp}, {"travel", travel}});
}
Scenario driven_cylinder(const Drive& drive) {
  return driven_scenario(
      block_robot(),
      {actuator("slide", "flow_source", {{"gain", kOilSpeed}, {"stiffness", kOilSpring}, {"damping", kOilLoss}})},
      drive, kAtRest);
}
/// Full flow up for 4 s (a way of .8 m), down for 4 s, and up again.
Drive to_and_fro() {
  Drive out = constant_drive(1, 10.0, 0.01, 1.0);
  for (std::size_t k = 400; k < 800; ++k) out.u[0][k] = -1.0;
  return out;
}
std::vector<double> positions(const EffectSpec& spec, double step = 1e-3) {
  const Scenario scenario = driven_cylinder(to_and_fro());
  const PlantModel model = PlantModel(scenario).with_effects({spec});
  return predict_one(model, started_experiment(scenario, kAtRest), on("featherstone", step)).front()[0];
}

// The oil is compressed by no more than passes while the joint comes to rest, and the contact gives k_oil/k of that.
constexpr double kPressedIn = 1e-3;  // m
constexpr double kOneSwing = 0.02;   // m, of one period of the oil spring at full speed

TEST(EndStop, HoldsACylinderAtBothEndsOfItsTravel) {
  for (const EffectSpec& spec : {stops(kContact, kTop, kTravel), stops(-kContact, kTop - kTravel, kTravel)}) {
    const std::vector<double> x = positions(spec);
    EXPECT_NEAR(x[399], kTop, kPressedIn);
    EXPECT_NEAR(x[799], kTop - kTravel, kPressedIn);
    EXPECT_LT(*std::max_element(x.begin(), x.end()), kTop + kOneSwing);
    EXPECT_GT(*std::min_element(x.begin(), x.end()), kTop - kTravel - kOneSwing);
  }
}

TEST(EndStop, HoldsItOnOneSideAloneWhereNothingIsSaidOfTheOther) {
  const std::vector<double> x = positions(stops(kContact, kTop, 1e6));
  EXPECT_NEAR(x[399], kTop, kPressedIn);
  EXPECT_NEAR(x[799], kTop - 4.0 * kOilSpeed, kOneSwing);
}

TEST(EndStop, IsLeftAsSoonAsTheFlowIsTurned) {
  // Pressed against the top for 2.5 s: a drive that stored that flow would come away .5 m, or 2.5 s, late.
  const std::vector<double> x = positions(stops(kContact, kTop, kTravel));
  for (std::size_t k = 450; k < 600; k += 10)
    EXPECT_NEAR(x[k], kTop - kOilSpeed * 0.01 * static_cast<double>(k - 400), kOneSwing) << k;
}

TEST(EndStop, IsCarriedByTheIndependentIntegratorAsByTheSteps) {
  const EffectSpec spec = stops(kContact, kTop, kTravel);
  const Scenario scenario = driven_cylinder(to_and_fro());
  const PlantModel model = PlantModel(scenario).with_effects({spec});
  const Experiment experiment = started_experiment(scenario, kAtRest);
  TruthOptions options;
  options.engine = "featherstone", options.settle = false;
  const auto truth =
      simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options).front();
  // The contact begins inside a step h: its damper misses k T v h/m of the speed there, which fades within m/(k T), so
  // that v h = .2 mm is the most that the place can be off.
  EXPECT_LT(worst_difference(positions(spec, 1e-3), truth), 2e-4);
  EXPECT_LT(worst_difference(positions(spec, 2.5e-4), truth), 5e-5);
}

}  // namespace
}  // namespace lacuna
