#include "cli/recording_sets.h"

#include <algorithm>
#include <fstream>
#include <set>

#include "scenarios/error.h"
#include "scenarios/recording_check.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

constexpr double kTrainPart = 0.6, kKnownPart = 0.8;  ///< of a lone recording's time: train up to, validate up to

bool is_bag_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path / "metadata.yaml", ignored);
}

bool is_recording(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) return is_bag_folder(file);
  const std::string end = file.extension().string();
  return end == ".csv" || end == ".mat" || end == ".db3" || end == ".mcap";
}

/// Files and bags in a folder; a bag's own folder is one recording.
std::vector<fs::path> files_in(const fs::path& folder) {
  if (is_bag_folder(folder)) return {folder};
  std::vector<fs::path> out;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (is_recording(entry.path())) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<fs::path> files_listed(const fs::path& list) {
  std::vector<fs::path> out;
  std::ifstream in(list);
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (!line.empty() && line.front() != '#')
      out.push_back(fs::path(line).is_absolute() ? fs::path(line) : list.parent_path() / line);
  }
  return out;
}

/// What one word of the set stands for.
std::vector<fs::path> files_of(const std::string& word, const std::string& argument) {
  const fs::path path(word);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    std::vector<fs::path> out = files_in(path);
    if (out.empty())
      throw InputError(argument, "no recording in " + quoted(word),
                       "a folder with .csv, .mat, .db3 or .mcap files, or bags");
    return out;
  }
  if (!fs::exists(path, ignored))
    throw InputError(argument, "no file " + quoted(word),
                     "a folder, a recording (.csv, .mat, .db3, .mcap, a bag's folder) or a list of them (.txt)");
  if (path.extension() == ".txt") return files_listed(path);
  if (!is_recording(path))
    throw InputError(
        argument, quoted(word),
        "with --scenario a folder, a recording (.csv, .mat, .db3, .mcap, a bag's folder) or a list of them (.txt)");
  return {path};
}

RecordingSpec entry(const fs::path& file, Role role, const std::string& where) {
  RecordingSpec out;
  out.file = fs::absolute(file).lexically_normal().string();
  out.role = role, out.where = where;
  return out;
}

/// First and last time of a loaded recording.
std::pair<double, double> times_of(const Scenario& scenario, const RecordingSpec& spec) {
  const std::vector<double>& time = spec.data->columns[spec.data->find(scenario.channels.time)];
  return {time.front(), time.back()};
}

/// The last recording's parts under other roles, cut at shares of its time.
void cut_last(Scenario& scenario, const std::vector<std::pair<Role, double>>& parts) {
  const RecordingSpec whole = scenario.recordings.back();
  const auto [first, last] = times_of(scenario, whole);
  scenario.recordings.pop_back();
  std::optional<double> from;
  for (const auto& [role, until] : parts) {
    RecordingSpec part = whole;
    part.role = role, part.from = from;
    from = first + until * (last - first);
    part.to = until < 1.0 ? from : std::nullopt;
    scenario.recordings.push_back(std::move(part));
  }
}

}  // namespace

Scenario with_recording_set(const Scenario& scenario, const std::string& set, const std::string& argument) {
  std::vector<fs::path> files;
  for (std::size_t begin = 0; begin <= set.size();) {
    const std::size_t end = std::min(set.find(',', begin), set.size());
    const std::vector<fs::path> more = files_of(set.substr(begin, end - begin), argument);
    files.insert(files.end(), more.begin(), more.end());
    begin = end + 1;
  }
  if (files.empty()) throw InputError(argument, "no recording in " + quoted(set), "at least one");
  Scenario out = scenario;
  out.recordings.clear(), out.events.clear();
  out.name = fs::path(set).lexically_normal().filename().replace_extension().string();
  if (out.name.empty() || set.find(',') != std::string::npos) out.name = files.front().stem().string();
  std::set<fs::path> seen;
  for (const fs::path& file : files) {
    if (!seen.insert(fs::weakly_canonical(file)).second)
      throw InputError(argument, quoted(file.string()) + " twice", "each recording once");
    const std::size_t k = out.recordings.size();
    const Role role = k + 1 == files.size() && k > 1   ? Role::test
                      : k + 2 == files.size() && k > 0 ? Role::validate
                                                       : Role::train;
    out.recordings.push_back(entry(file, role, argument));
  }
  load_and_check_recordings(out);
  if (files.size() == 1) cut_last(out, {{Role::train, kTrainPart}, {Role::validate, kKnownPart}, {Role::test, 1.0}});
  if (files.size() == 2) cut_last(out, {{Role::validate, 0.5}, {Role::test, 1.0}});
  for (EffectSpec& effect : out.effects)
    if (!effect.recordings.empty())
      throw InputError(scenario.file.string() + ": effects", effect.effect + " in some recordings only",
                       "one that acts in all, where --scenario reads other recordings");
  return out;
}

}  // namespace lacuna
