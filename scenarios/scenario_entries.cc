#include "scenarios/scenario_entries.h"

namespace lacuna {

void put_column(YamlWriter& yaml, const std::string& joint, const ColumnSpec& spec) {
  if (spec.scale == 1.0 && spec.offset == 0.0 && spec.unit.empty()) {
    yaml.put(joint, spec.column);
    return;
  }
  yaml.key(joint).short_map().put("column", spec.column);
  if (spec.scale != 1.0) yaml.put("scale", spec.scale);
  if (spec.offset != 0.0) yaml.put("offset", spec.offset);
  if (!spec.unit.empty()) yaml.put("unit", spec.unit);
  yaml.end();
}

namespace {

void put_simulation(YamlWriter& yaml, const Prediction& prediction) {
  if (const auto* windows = std::get_if<Windows>(&prediction)) {
    yaml.short_map().put("horizon", windows->horizon).end();
  } else if (const auto* inverse = std::get_if<InverseDynamics>(&prediction)) {
    yaml.short_map().key("inverse_dynamics").short_map().put("cutoff_hz", inverse->cutoff_hz).end().end();
  } else {
    yaml.value("free_run");
  }
}

}  // namespace

void put_prediction(YamlWriter& yaml, const Prediction& prediction, bool pressure_driven) {
  yaml.key("prediction");
  if (pressure_driven) {
    yaml.short_map().key("pressure_driven");
    put_simulation(yaml, prediction);
    yaml.end();
    return;
  }
  put_simulation(yaml, prediction);
}

}  // namespace lacuna
