// Entries of a scenario file that a saved scenario (save_scenario) and a drafted one (draft/) have in common.
#pragma once

#include <string>

#include "scenarios/scenario.h"
#include "scenarios/yaml_writer.h"

namespace lacuna {

/// `joint: column`, or `joint: {column: ..., scale: ..., offset: ..., unit: ...}` where it says more than the column.
void put_column(YamlWriter& yaml, const std::string& joint, const ColumnSpec& spec);

/// `prediction: ...`.
void put_prediction(YamlWriter& yaml, const Prediction& prediction, bool pressure_driven = false);

}  // namespace lacuna
