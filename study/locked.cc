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

/// Where a body of the old robot went.
struct Ride {
  int body = -1;  ///< in the new robot; -1 the world
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

std::shared_ptr<const Robot> welded_robot(const Robot& robot, const std::vector<bool>& locked) {
  std::vector<Ride> rides;
  std::vector<Joint> joints;
  for (std::size_t i = 0; i < locked.size(); ++i) {
    const Joint& old = robot.joints()[i];
    const Ride parent = old.parent < 0 ? Ride{} : rides[static_cast<std::size_t>(old.parent)];
    Joint joint = old;
    joint.parent = parent.body;
    joint.origin = parent.pose * old.origin;
    if (locked[i]) {
      rides.push_back({parent.body, joint.origin});
    } else {
      rides.push_back({static_cast<int>(joints.size()), Eigen::Isometry3d::Identity()});
      joints.push_back(std::move(joint));
    }
  }
  std::vector<Link> links = robot.links();
  for (Link& link : links) {
    if (link.body < 0) continue;
    const Ride& ride = rides[static_cast<std::size_t>(link.body)];
    link.body = ride.body;
    link.in_body = ride.pose * link.in_body;
  }
  return std::make_shared<const Robot>(robot.name(), std::move(joints), std::move(links), robot.name());
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
  out.scenario.robot = welded_robot(*scenario.robot, locked);
  std::erase_if(out.scenario.effects, [&](const EffectSpec& effect) {
    return std::find(out.fixed.begin(), out.fixed.end(), effect.place) != out.fixed.end();
  });
  const PlantModel model(out.scenario);
  std::erase_if(out.scenario.identify, [&](const IdentifySpec& spec) { return model.matching(spec.name).empty(); });
  return out;
}

}  // namespace lacuna
