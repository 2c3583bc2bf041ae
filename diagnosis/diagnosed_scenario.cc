// The answer put back into the scenario, so that it runs again as it is.
#include <algorithm>

#include "diagnosis/diagnosis.h"

namespace lacuna {

Scenario with_values(const Scenario& scenario, const PlantModel& model, std::span<const double> values) {
  Scenario out = scenario;
  auto value_of = [&](const std::string& name, double& target) {
    const int index = model.find(name);
    if (index >= 0) target = values[static_cast<std::size_t>(index)];
  };
  for (ActuatorSpec& actuator : out.actuators) {
    for (const ParameterInfo& p :
         actuator_table()[static_cast<std::size_t>(find_actuator(actuator.model))].parameters) {
      value_of(actuator.joint + "." + p.name, actuator.parameters[p.name]);
    }
  }
  out.effects.clear();
  for (const Component& component : model.effects()) {
    EffectSpec spec{effect_table()[static_cast<std::size_t>(component.type)].name,
                    model.place_name(component),
                    {},
                    component.recordings,
                    ""};
    for (int k = 0; k < component.count; ++k) {
      const auto index = static_cast<std::size_t>(component.first + k);
      spec.parameters[model.parameters()[index].key] = values[index];
    }
    out.effects.push_back(std::move(spec));
  }
  return out;
}

Scenario diagnosed_scenario(const Scenario& scenario, const Diagnosis& diagnosis) {
  const PlantModel plain(scenario);
  return with_values(scenario, plain.with_effects(diagnosis.added), diagnosis.after.values);
}

}  // namespace lacuna
