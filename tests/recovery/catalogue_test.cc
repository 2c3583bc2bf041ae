// Every effect of the catalogue, planted on two rods and left out of their scenario, is named, or stands in the class
// of what is named: by another engine's and another integrator's recordings, with other parameters and white noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "diagnosis/diagnosis.h"
#include "physics/catalogue.h"
#include "tests/diagnosis/outside.h"
#include "tests/physics/efforts.h"
#include "tests/physics/plants.h"
#include "trial/conceal.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kVisible = 6.0;                           // times the noise, after a plain refit
constexpr double kReading = 5e-4;                          // rad, a transducer's noise
constexpr double kFineReading = 1e-5, kEffortNoise = 0.5;  // rad, N m: of an arm whose efforts are measured

bool drives_by_flow(const EffectInfo& info) {
  return info.hydraulic || info.metering || needs_flow(find_effect(info.name));
}

/// Two rods on springs and dampers, or as an effect needs them, their motion recorded without it.
Scenario recorded(const EffectInfo& info) {
  Scenario scenario = bare_scenario(
      bundled_robot("double_pendulum/double_pendulum.urdf"),
      {actuator("shoulder", "torque_source", {{"gain", 6.0}, {"damping", 2.0}, {"stiffness", 8.0}, {"rest", 0.2}}),
       actuator("elbow", "torque_source", {{"gain", 2.0}, {"damping", 0.5}, {"stiffness", 3.0}, {"rest", -0.3}})},
      false);
  if (drives_by_flow(info))
    for (ActuatorSpec& drive : scenario.actuators)
      drive = actuator(drive.joint, "flow_source", {{"gain", 0.2}, {"stiffness", 400.0}, {"damping", 5.0}});
  int k = 0;
  for (const Role role : {Role::train, Role::train, Role::validate, Role::test}) {
    const std::string file = "run_" + std::to_string(k) + ".csv";
    add_recording(scenario,
                  recording_of(*scenario.robot, rested_drive(10.0, 7.3 * k, 2), {{0.1, 0.1}, {0.0, 0.0}, false}, file),
                  role);
    ++k;
  }
  for (const char* joint : {"shoulder", "elbow"}) scenario.noise[ChannelKind::position][joint] = kReading;
  for (const char* name : {"gain", "damping", "stiffness"})
    scenario.identify.push_back({name, true, 0.25, 4.0, std::string("test: identify.") + name});
  ConcealOptions plain;
  plain.engine = another_engine();
  plain.perturb_least = plain.perturb_most = 0.0;
  return conceal(scenario, plain).scenario;
}

/// The rods moved by efforts that are measured, their motion, too.
Scenario recorded_with_efforts(const EffectInfo& info) {
  Scenario scenario = pushed_rods();
  // Where the drives' damping is searched, it takes up any viscous friction.
  if (info.name != std::string("viscous_friction")) scenario.identify = {{"damping", true, 0.2, 5.0, "test: identify"}};
  int k = 0;
  for (const Role role : {Role::train, Role::train, Role::validate, Role::test}) {
    const Drive drive = sines_at(clock(10.0, 0.001), 6.0, 7.3 * k);
    add_recording(scenario, truth_recording(scenario, drive, "run_" + std::to_string(k) + ".csv"), role);
    ++k;
  }
  for (const Joint& joint : scenario.robot->joints()) {
    scenario.noise[ChannelKind::position][joint.name] = scenario.noise[ChannelKind::velocity][joint.name] =
        kFineReading;
    scenario.noise[ChannelKind::effort][joint.name] = kEffortNoise;
  }
  scenario.prediction = InverseDynamics{8.0};
  return scenario;
}

std::string place_of(const EffectInfo& info) { return info.where == Where::arm ? "arm" : "elbow"; }

/// As strong as it is to be. Level rods in a plane that stands upright show a roll of their base by its cosine alone.
Scenario planted(const EffectInfo& info) {
  const std::string name = info.name;
  ConcealOptions options;
  options.engine = another_engine();
  options.threads = 2;
  if (!info.in_efforts) options.visibility = kVisible;  // else as strong as is typical
  options.effects = {parse_hidden_effect(name + ":" + place_of(info))};
  if (name == "base_tilt") {
    options.visibility.reset();
    options.effects = {parse_hidden_effect("base_tilt:arm:roll=1e-4,pitch=0.05")};
  }
  return conceal(info.in_efforts ? recorded_with_efforts(info) : recorded(info), options).scenario;
}

/// But for what this experiment cannot show (the scale of efforts without a known load; a spring of oil that changes
/// along the stroke, which is sought in efforts behind drives of flow), and for a known gap: a relief valve that opens
/// far below the drive's usual effort, from which every search for it begins.
std::vector<std::string> shown_by_two_rods() {
  const std::set<std::string> left_out{"effort_scale", "oil_compressibility", "relief"};
  std::vector<std::string> out;
  for (const EffectInfo& info : effect_table())
    if (!info.learned && !left_out.contains(info.name)) out.emplace_back(info.name);
  return out;
}

class Planted : public testing::TestWithParam<std::string> {};

TEST_P(Planted, StandsInTheClassOfWhatIsNamedAtItsPlace) {
  const std::string name = GetParam();
  const EffectInfo& info = effect_table()[find_effect(name)];
  const Diagnosis d = diagnosed(planted(info));
  std::string said = to_string(d.verdict);
  bool found = false;
  for (const Finding& finding : d.findings) {
    said += " " + finding.effect + ":" + finding.place;
    for (const std::string& member : finding.members) said += "," + member;
    found = found || (finding.place == place_of(info) &&
                      (finding.effect == name || std::ranges::count(finding.members, name) > 0));
  }
  EXPECT_TRUE(found) << "said: " << said;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, Planted, testing::ValuesIn(shown_by_two_rods()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace lacuna
