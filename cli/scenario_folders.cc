#include "cli/scenario_folders.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/command.h"
#include "scenarios/error.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

constexpr int kDeepest = 8;                    // folders below the one named
constexpr std::size_t kMostEntries = 1000000;  // files and folders looked at

bool holds_scenario(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / "scenario.yaml", ignored);
}

}  // namespace

std::vector<ScenarioFolder> scenario_folders(const fs::path& root, const fs::path& out) {
  std::error_code error;
  if (!fs::is_directory(root, error)) throw InputError(root.string(), "no folder", "a folder with cases below it");
  if (holds_scenario(root)) return {{file_name(fs::weakly_canonical(root).filename().string()), root}};
  std::vector<ScenarioFolder> cases;
  std::size_t seen = 0;
  fs::recursive_directory_iterator entry(root, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (++seen > kMostEntries)
      throw InputError(root.string(), fmt::format("more than {} files", kMostEntries), "a folder of cases");
    std::error_code ignored;
    if (!entry->is_directory(ignored)) continue;
    const bool results = fs::equivalent(entry->path(), out, ignored);
    const bool is_case = !results && holds_scenario(entry->path());
    if (is_case) cases.push_back({entry->path().lexically_relative(root).generic_string(), entry->path()});
    if (is_case || results || entry.depth() >= kDeepest) entry.disable_recursion_pending();
  }
  if (error) throw InputError(root.string(), error.message(), "a folder that can be read");
  if (cases.empty()) throw InputError(root.string(), "no folder with a scenario.yaml", "at least one case below it");
  std::sort(cases.begin(), cases.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return cases;
}

}  // namespace lacuna
