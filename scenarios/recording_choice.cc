#include "scenarios/recording_choice.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "scenarios/error.h"
#include "scenarios/recording_check.h"
#include "scenarios/recording_formats.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

/// One entry over all time ranges in which the scenario uses this file.
RecordingSpec united(const Scenario& scenario, const RecordingSpec& named) {
  RecordingSpec out = named;
  for (const RecordingSpec& spec : scenario.recordings) {
    if (!same_file(resolve(scenario, spec.file), resolve(scenario, named.file))) continue;
    out.from = out.from && spec.from ? std::optional(std::min(*out.from, *spec.from)) : std::nullopt;
    out.to = out.to && spec.to ? std::optional(std::max(*out.to, *spec.to)) : std::nullopt;
  }
  return out;
}

/// Measured channels whose column the file does not have.
struct Absent {
  ChannelKind kind;
  std::string joint;
  ColumnSpec column;
};

std::vector<Absent> take_absent(Scenario& scenario, const Recording& data) {
  std::vector<Absent> out;
  for (auto& [kind, joints] : scenario.channels.of) {
    if (kind == ChannelKind::command) continue;
    for (auto at = joints.begin(); at != joints.end();) {
      if (data.find(at->second.column) >= 0) {
        ++at;
        continue;
      }
      out.push_back({kind, at->first, at->second});
      at = joints.erase(at);
    }
  }
  return out;
}

}  // namespace

std::vector<RecordingSpec> recordings_of(const Scenario& scenario) {
  std::vector<RecordingSpec> out;
  for (const RecordingSpec& spec : scenario.recordings) {
    const bool seen = std::any_of(out.begin(), out.end(), [&](const RecordingSpec& other) {
      return same_file(resolve(scenario, other.file), resolve(scenario, spec.file));
    });
    if (!seen) out.push_back(united(scenario, spec));
  }
  return out;
}

RecordingSpec recording_named(const Scenario& scenario, const std::string& name) {
  std::vector<std::string> known;
  for (const RecordingSpec& spec : scenario.recordings) {
    if (spec.file == name) return united(scenario, spec);
    if (std::find(known.begin(), known.end(), spec.file) == known.end()) known.push_back(spec.file);
  }
  std::error_code ignored;
  fs::path file = name;
  if (!fs::exists(file, ignored)) file = resolve(scenario, name);
  if (name.empty() || !fs::exists(file, ignored))
    throw InputError("--recording", "no file " + quoted(name),
                     known.empty() ? kRecordingKinds : "a recording: " + one_of(known));
  for (const RecordingSpec& spec : scenario.recordings)
    if (same_file(resolve(scenario, spec.file), file)) return united(scenario, spec);
  RecordingSpec spec;
  spec.file = fs::absolute(file).lexically_normal().string();
  spec.where = "--recording";
  return spec;
}

Scenario with_recording(Scenario scenario, const RecordingSpec& spec) {
  const fs::path path = resolve(scenario, spec.file);
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw InputError(spec.where + ".file", "no file " + quoted(spec.file), kRecordingKinds);
  scenario.recordings = {spec};
  scenario.recordings.front().role = Role::train;  // the role that start values and steps are taken from
  scenario.prediction = FreeRun{};
  const std::vector<Absent> absent =
      take_absent(scenario, read_recording(parts_of(scenario, spec), {}, column_use(scenario.channels)));
  load_and_check_recordings(scenario);
  if (absent.empty()) return scenario;
  Recording data = *scenario.recordings.front().data;
  for (const Absent& channel : absent) {
    scenario.channels.of[channel.kind][channel.joint] = channel.column;
    data.names.push_back(channel.column.column);
    data.columns.emplace_back(data.rows(), std::nan(""));
  }
  scenario.recordings.front().data = std::make_shared<const Recording>(std::move(data));
  return scenario;
}

}  // namespace lacuna
