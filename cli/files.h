// What identify and diagnose leave behind beside their reports, and how an unfinished run knows itself again.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "physics/plant_model.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// Writes `scenario` (with identified values put in) as `folder/yaml_name`, its robot with `link_masses` beside it as
/// <robot>.identified.urdf, and copies of the recordings, so that it runs again as it is. `source` is the scenario as
/// loaded. Returns the names of the files written, recordings left out. Throws WriteError.
std::vector<std::string> write_model_files(const std::filesystem::path& folder, const std::string& yaml_name,
                                           const Scenario& source, Scenario scenario,
                                           std::span<const double> link_masses);

/// What a run is about: hash of scenario, robot and recordings, and in clear the words given. A checkpoint is resumed
/// only by a run of the same fingerprint.
std::string fingerprint(const Scenario& scenario, const std::vector<std::string>& words);

}  // namespace lacuna
