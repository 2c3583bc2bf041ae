// The answer put back into the scenario, so that it runs again as it is.
#include <algorithm>

#include "diagnosis/diagnosis.h"

namespace lacuna {
namespace {

/// What is searched, parameter by parameter and in absolute bounds: relative ones would move with the start values, and
/// a kind would name parameters of the effects put in, too. `values` lie within them, whatever their last digit.
std::vector<IdentifySpec> same_space(const Scenario& scenario, std::span<const double> values) {
  const PlantModel plain(scenario);
  std::vector<IdentifySpec> out;
  for (const IdentifySpec& spec : scenario.identify) {
    const std::vector<int> found = plain.matching(spec.name);
    for (const int index : found) {
      const Parameter& p = plain.parameters()[index];
      const double factor = spec.relative ? p.value : 1.0, value = values[index];
      const auto [lower, upper] = std::minmax({factor * spec.lower, factor * spec.upper});
      const IdentifySpec own{p.name, false, std::min(lower, value), std::max(upper, value), spec.where};
      const auto same = std::find_if(out.begin(), out.end(), [&](const IdentifySpec& s) { return s.name == p.name; });
      if (same == out.end()) {
        out.push_back(own);
      } else if (found.size() == 1) {
        *same = own;  // a full name refines its kind
      }
    }
  }
  return out;
}

}  // namespace

Scenario with_values(const Scenario& scenario, const PlantModel& model, std::span<const double> values) {
  Scenario out = scenario;
  out.identify = same_space(scenario, values);
  auto value_of = [&](const std::string& name, double& target) {
    const int index = model.find(name);
    if (index >= 0) target = values[index];
  };
  for (ActuatorSpec& actuator : out.actuators) {
    for (const ParameterInfo& p : actuator_table()[find_actuator(actuator.model)].parameters) {
      value_of(actuator.joint + "." + p.name, actuator.parameters[p.name]);
    }
  }
  out.effects.clear();
  for (const Component& component : model.effects()) {
    EffectSpec spec{effect_table()[component.type].name, model.place_name(component), {}, component.recordings, ""};
    for (int k = 0; k < component.count; ++k) {
      const std::size_t index = component.first + k;
      spec.parameters[model.parameters()[index].key] = values[index];
    }
    out.effects.push_back(std::move(spec));
  }
  return out;
}

Scenario diagnosed_scenario(const Scenario& scenario, const Diagnosis& diagnosis) {
  const PlantModel plain(scenario);
  Scenario out = with_values(scenario, plain.with_effects(diagnosis.added), diagnosis.after.values);
  for (const LearnedEvent& event : diagnosis.events)
    if (event.role != Role::test) out.events.insert(out.events.end(), event.pieces.begin(), event.pieces.end());
  return out;
}

}  // namespace lacuna
