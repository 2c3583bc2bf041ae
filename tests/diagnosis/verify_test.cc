// What is said of the test recordings, on every engine.
#include "diagnosis/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/baseline.h"
#include "ga/start_effects.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

TEST(Verify, NamesEachJointWhoseResidualGrewByMoreThanNoiseDoes) {
  const JointRms before{{"a", 1.0}, {"a.velocity", 1.0}, {"b", 1.0}, {"c", 1.0}, {"a2", 1.0}};
  const JointRms after{{"a", 0.5}, {"a.velocity", 1.1}, {"b", 1.015}, {"c", 1.03}, {"a2", std::nan("")}};
  EXPECT_EQ(joints_that_grew(before, after, {"a", "b", "c", "a2"}), (std::vector<std::string>{"a", "c"}));
  EXPECT_TRUE(joints_that_grew(before, before, {"a", "b", "c"}).empty());
  EXPECT_TRUE(joints_that_grew({}, after, {"a"}).empty());
}

TEST(Verify, TakesWhatStartsDoOffTheGainOfEveryEngine) {
  constexpr double kTransducerNoise = 1e-4;  // m or rad
  // The swing has friction that the plain model lacks. The slide is not driven; where it starts is known to 2 cm only.
  Scenario scenario = two_machines({}, {}, kTransducerNoise), truth = scenario;
  Drive drive = rested_drive(8.0, 0.0, 2);
  std::ranges::fill(drive.u[0], 0.0);
  truth.effects = {effect("coulomb_friction", "swing", {{"Fc", 0.3}})};
  const Start rest{{0.0, 0.0}, {0.0, 0.0}, false};
  for (const Role role : {Role::train, Role::test})
    add_recording(scenario,
                  simulated_recording(truth, drive, rest, engine_of_data(), to_string(role), kTransducerNoise, 3),
                  role);
  for (const char* name : {"slide.damping", "swing.damping"})
    scenario.identify.push_back({name, true, 0.2, 5.0, "test"});
  const PlantModel model(scenario);
  Experiment experiment = make_experiment(scenario);
  for (Segment& segment : experiment.segments) segment.q0[0] += 0.02, segment.q0_error[0] = 0.02;
  const FitContext context{experiment, on("featherstone", 0.005)};
  CurrentModel before{model, SearchSpace(model, scenario), {kTransducerNoise, 0.05}, {}};
  evaluate_at(before, before.space.start(), context);
  ASSERT_TRUE(attach_start_effects(experiment, model, context.simulator, before.space.expand(before.fit.point)));
  // With less damping the wrong start rings on for longer.
  std::vector<double> point = before.fit.point;
  point[0] = before.space.contract([&] {
    std::vector<double> values = model.values();
    values[model.find("slide.damping")] *= 0.97;
    return values;
  }())[0];
  CurrentModel after = extended(before, experiment, effect("coulomb_friction", "swing", {{"v0", 0.0}}), point, {0.3});
  evaluate_at(after, after.fit.point, context);
  Diagnosis out;
  verify(out, before, after, context, true);
  ASSERT_GT(out.engines.size(), 1u);
  for (const EngineGain& engine : out.engines) {
    if (!engine.available) continue;
    EXPECT_GT(engine.after[0].second, 1.005 * engine.before[0].second) << "the slide's residual grew";
    EXPECT_NEAR(engine.kept, 1.0, 0.01) << engine.engine;
  }
}

}  // namespace
}  // namespace lacuna
