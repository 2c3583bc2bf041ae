// One pump for two valves, planted by another integrator: found where they are open at once, and nowhere else.
#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"
#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kReading = 2e-4;  // rad
constexpr double kPeriod = 0.02, kHeld = 1.2;
constexpr double kShoulderFull = 6.0, kElbowFull = 9.0;  // V
const std::vector<EffectSpec> kOverlaps{effect("valve_deadband", "shoulder", {{"d", 1.0}}),
                                        effect("valve_deadband", "elbow", {{"d", 0.8}})};
using Steps = std::vector<std::array<double, 2>>;  ///< V, of shoulder and elbow

EffectSpec pump() {
  return effect("shared_supply", "arm", {{"full_shoulder", kShoulderFull}, {"full_elbow", kElbowFull}});
}

Scenario arm(double error) {
  const auto cylinder = [&](const char* joint, double gain) {
    return actuator(joint, "flow_source", {{"gain", gain * error}, {"stiffness", 600.0}, {"damping", 30.0}});
  };
  Scenario out = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                               {cylinder("shoulder", 0.05), cylinder("elbow", 0.08)}, false);
  for (const char* joint : {"shoulder", "elbow"}) out.noise[ChannelKind::position][joint] = kReading;
  return out;
}

Drive held(const Steps& steps) {
  const double seconds = kHeld * static_cast<double>(steps.size() + 1);
  Drive out = constant_drive(2, seconds, kPeriod, 0.0);
  for (std::size_t k = 0; k < out.time.size(); ++k) {
    const auto step = static_cast<std::size_t>(std::max(0.0, out.time[k] / kHeld - 0.5));
    for (const std::size_t j : {0u, 1u})
      out.u[j][k] = out.time[k] < 0.5 * kHeld || step >= steps.size() ? 0.0 : steps[step][j];
  }
  return out;
}

/// What the concealed machine does under these commands, made by Simbody's or another engine and Dormand and Prince.
void record(Scenario& to, const std::vector<EffectSpec>& concealed, const Steps& steps, Role role,
            const std::string& file, std::uint64_t seed) {
  const Start still{{0.0, 0.0}, {0.0, 0.0}, false};
  Scenario truth = arm(1.0);
  truth.effects = concealed;
  const auto data = recording_of(*truth.robot, held(steps), still, file);
  add_recording(truth, data);
  const PlantModel model(truth);
  const Experiment experiment = started_experiment(truth, still);
  TruthOptions options;
  options.engine = available_engines().back();
  const auto moved = simulate_truth(model, experiment.segments.front(), experiment.channels, model.values(), options);
  Noise random(seed);
  for (std::size_t c = 0; c < moved.size(); ++c) {
    auto& column = data->columns[static_cast<std::size_t>(data->find(c == 0 ? "q_shoulder" : "q_elbow"))];
    column = moved[c];
    for (double& x : column) x += kReading * random();
  }
  add_recording(to, data, role);
}

const Steps kOneAtATime{{3.0, 0.0}, {-3.0, 0.0}, {10.0, 0.0}, {-10.0, 0.0},
                        {0.0, 9.0}, {0.0, -9.0}, {5.0, 0.0},  {0.0, 4.0}};
const Steps kBoth{{9.0, 8.0},  {-9.0, -8.0}, {5.0, 9.0}, {-5.0, -9.0},
                  {9.0, -4.0}, {-9.0, 4.0},  {2.0, 2.0}, {-2.0, -2.0}};
const Steps kBothOtherwise{{10.0, -7.0}, {-10.0, 7.0}, {7.0, 10.0}, {0.0, -10.0}, {-7.0, 0.0}, {2.5, 3.0}};
const Steps kOneAtATimeOtherwise{{7.0, 0.0}, {-7.0, 0.0}, {0.0, 6.0}, {4.0, 0.0}, {-9.0, 0.0}, {0.0, -6.0}};

Scenario machine(const std::vector<EffectSpec>& concealed, bool together) {
  Scenario out = arm(1.2);
  for (const char* name : {"shoulder.gain", "elbow.gain"}) out.identify.push_back({name, true, 0.2, 5.0, "test"});
  record(out, concealed, kOneAtATime, Role::train, "one.csv", 3);
  if (together) record(out, concealed, kBoth, Role::train, "both.csv", 5);
  record(out, concealed, together ? kBothOtherwise : kOneAtATimeOtherwise, Role::validate, "validate.csv", 7);
  record(out, concealed, together ? kBothOtherwise : kOneAtATimeOtherwise, Role::test, "test.csv", 11);
  return out;
}

Diagnosis found_in(const Scenario& scenario) {
  DiagnoseOptions options;
  options.identify.optimizer = Optimizer::lsq;
  options.identify.simulator.engine = "featherstone";
  options.other_engines = false;
  return diagnose(scenario, options);
}

bool says(const Finding& f, const char* effect) {
  return f.effect == effect || std::count(f.members.begin(), f.members.end(), effect) > 0;
}

TEST(SharedSupply, IsNamedBesideTheValvesWhereBothAreOpenAtOnce) {
  std::vector<EffectSpec> concealed = kOverlaps;
  concealed.push_back(pump());
  const Diagnosis d = found_in(machine(concealed, true));
  EXPECT_EQ(d.verdict, Verdict::missing_physics);
  const auto at = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return f.place == "arm"; });
  ASSERT_NE(at, d.findings.end());
  EXPECT_TRUE(says(*at, "shared_supply")) << at->effect;
  EXPECT_GT(at->probability, 0.9);
  for (const auto& p : at->parameters) {
    if (p.name == "full_shoulder") EXPECT_NEAR(p.value, kShoulderFull, 0.05 * kShoulderFull);
    if (p.name == "full_elbow") EXPECT_NEAR(p.value, kElbowFull, 0.05 * kElbowFull);
  }
  for (const char* joint : {"shoulder", "elbow"})
    EXPECT_TRUE(std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
      return f.place == joint && says(f, "valve_deadband");
    })) << joint;
  ASSERT_EQ(d.after.rms.back().first, Role::test);
  for (const auto& [joint, rms] : d.after.rms.back().second) EXPECT_LT(rms, 1.3 * kReading) << joint;
}

TEST(SharedSupply, OfOneValveAtATimeIsNotClaimedAndNotEvenSought) {
  std::vector<EffectSpec> concealed = kOverlaps;
  concealed.push_back(pump());
  const Scenario scenario = machine(concealed, false);
  const Diagnosis d = found_in(scenario);
  for (const Finding& f : d.findings) EXPECT_NE(f.place, "arm") << f.effect;
  EXPECT_TRUE(std::any_of(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return says(f, "actuator_saturation");
  })) << "each alone is at the pump's limit all the same";
}

}  // namespace
}  // namespace lacuna
