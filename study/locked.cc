#include "study/locked.h"

#include <algorithm>

#include "physics/plant_model.h"

namespace lacuna {
namespace {

constexpr double kBrake = 1e5;  // N m (N): no actuator of an arm comes near it

bool is_brake(const EffectSpec& effect) {
  const auto value = [&](const char* name) {
    const auto at = effect.parameters.find(name);
    return at == effect.parameters.end() ? 0.0 : at->second;
  };
  return effect.effect == "coulomb_friction" && effect.recordings.empty() && value("Fc") >= kBrake &&
         value("v0") == 0.0;
}

bool is_locked(const Scenario& scenario, const std::string& joint) {
  const auto here = [&](const auto& list, auto name_of) {
    return std::any_of(list.begin(), list.end(), [&](const auto& entry) { return name_of(entry) == joint; });
  };
  if (here(scenario.actuators, [](const ActuatorSpec& a) { return a.joint; })) return false;
  for (const auto& [kind, joints] : scenario.channels.of) {
    if (joints.count(joint) > 0) return false;
  }
  bool braked = false;
  for (const EffectSpec& effect : scenario.effects) {
    if (effect.place != joint) continue;
    if (!is_brake(effect)) return false;
    braked = true;
  }
  return braked;
}

}  // namespace

LockedScenario with_locked_joints_fixed(const Scenario& scenario) {
  LockedScenario out{scenario, {}};
  std::vector<bool> locked;
  for (const Joint& joint : scenario.robot->joints()) {
    locked.push_back(is_locked(scenario, joint.name));
    if (locked.back()) out.fixed.push_back(joint.name);
  }
  if (out.fixed.empty() || out.fixed.size() == locked.size() || scenario.total_mass) return {scenario, {}};
  out.scenario.robot = scenario.robot->with_joints_fixed(locked, std::vector<double>(locked.size(), 0.0));
  std::erase_if(out.scenario.effects, [&](const EffectSpec& effect) {
    return std::find(out.fixed.begin(), out.fixed.end(), effect.place) != out.fixed.end();
  });
  const PlantModel model(out.scenario);
  std::erase_if(out.scenario.identify, [&](const IdentifySpec& spec) { return model.matching(spec.name).empty(); });
  return out;
}

}  // namespace lacuna
