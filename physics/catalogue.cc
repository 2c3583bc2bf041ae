#include "physics/catalogue.h"

#include "physics/actuators/table.h"
#include "physics/effects/table.h"

namespace lacuna {
namespace {

template <class Info>
int find_in(const std::vector<Info>& table, const std::string& name) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (name == table[i].name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

const std::vector<ActuatorInfo>& actuator_table() {
  static const std::vector<ActuatorInfo> table = Actuators::infos<ActuatorInfo>();
  return table;
}

const std::vector<EffectInfo>& effect_table() {
  static const std::vector<EffectInfo> table = Effects::infos<EffectInfo>();
  return table;
}

int find_actuator(const std::string& name) { return find_in(actuator_table(), name); }
int find_effect(const std::string& name) { return find_in(effect_table(), name); }
bool of_whole_arm(const std::string& effect) {
  const int index = find_effect(effect);
  return index >= 0 && effect_table()[index].where == Where::arm;
}

bool integrates_flow(int actuator) { return actuator >= 0 && Actuators::hooks<double>()[actuator].flow != nullptr; }
bool lets_flow(int actuator) {
  return integrates_flow(actuator) || (actuator >= 0 && actuator_table()[actuator].chambers);
}
bool needs_flow(int effect) {
  const Hooks<double>& hooks = Effects::hooks<double>()[effect];
  return hooks.taken != nullptr && hooks.effort == nullptr;
}
bool suits(int effect, int actuator) {
  if (!needs_flow(effect) || integrates_flow(actuator)) return true;
  const bool chambers = Effects::hooks<double>()[effect].chambers != nullptr;
  return chambers && actuator >= 0 && actuator_table()[actuator].chambers;
}
bool acts_by_a_law(int effect) {
  const Hooks<double>& hooks = Effects::hooks<double>()[effect];
  return hooks.command != nullptr || hooks.effort != nullptr || hooks.dry_friction != nullptr;
}

const ParameterInfo& leading_parameter(const EffectInfo& effect) {
  const auto& p = effect.parameters;
  return p.front().scale == Scale::reach && p.size() > 1 ? p[1] : p.front();
}

double strengthened(const EffectInfo& effect, const ParameterInfo& p, double value, double factor) {
  const ParameterInfo& lead = leading_parameter(effect);
  if (p.coordinate == Coordinate::logarithm) return p.neutral == 0.0 ? value * factor : value / factor;
  const bool alike = effect.as_one || (p.scale == lead.scale && p.scale != Scale::ratio && !p.optional);
  if (p.name != lead.name && !alike) return value;
  return p.coordinate == Coordinate::inverse ? value / factor : p.neutral + factor * (value - p.neutral);
}

}  // namespace lacuna
