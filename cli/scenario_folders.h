// A folder of scenarios: what blind and compare are given.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lacuna {

struct ScenarioFolder {
  std::string name;  ///< path below the folder named
  std::filesystem::path folder;
};

/// Folders with a scenario.yaml below `root`, sorted by name; one holds no further ones, and `out`, where results go,
/// holds none either. Throws InputError where there is none.
std::vector<ScenarioFolder> scenario_folders(const std::filesystem::path& root, const std::filesystem::path& out);

}  // namespace lacuna
