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

}  // namespace lacuna
