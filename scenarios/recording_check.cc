#include "scenarios/recording_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_formats.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

/// Clocks that differ from `sample_period` by more than this share of it are an error (scenario.h).
constexpr double kPeriodTolerance = 0.01;

/// Rows [begin, end) of a recording that lie in [from, to].
struct Range {
  std::size_t begin = 0, end = 0;
};

/// "file:line" for CSV (a header, then one line a row), "file: value N" for MATLAB and what was brought onto one clock.
std::string row_place(const Recording& data, std::size_t row) {
  const std::string extension = std::filesystem::path(data.file).extension().string();
  const bool lines = !data.joined && extension != ".mat" && extension != ".MAT";
  return lines ? fmt::format("{}:{}", printable(data.file), row + 2)
               : fmt::format("{}: value {}", printable(data.file), row + 1);
}

const std::vector<double>& column_of(const Recording& data, const std::string& column, const std::string& where) {
  const int index = data.find(column);
  if (index < 0)
    throw InputError(where, fmt::format("the column {}, which {} does not have", quoted(column), printable(data.file)),
                     one_of(data.names));
  return data.columns[index];
}

/// A logger stopped before the last line held its time and commands: that line is no sample.
void drop_unusable_cut_row(Recording& data, const ChannelSpecs& channels, std::vector<std::string>& notes) {
  if (!data.cut || data.rows() < 2) return;
  std::set<std::string> needed{channels.time};
  if (const auto commands = channels.of.find(ChannelKind::command); commands != channels.of.end())
    for (const auto& [unused, spec] : commands->second) needed.insert(spec.column);
  const bool unusable = std::any_of(needed.begin(), needed.end(), [&](const std::string& name) {
    const int index = data.find(name);
    return index >= 0 && std::isnan(data.columns[index].back());
  });
  if (!unusable) return;
  for (auto& column : data.columns) {
    if (std::isnan(column.back())) --data.missing;
    column.pop_back();
  }
  notes.push_back(printable(data.file) + ": its last line stops before the end of time and commands and is left out");
}

void check_clock(const Recording& data, const std::string& name, const std::vector<double>& time) {
  for (std::size_t i = 0; i < time.size(); ++i) {
    const std::string where = row_place(data, i) + ": " + printable(name, 60);
    if (std::isnan(time[i])) throw InputError(where, "no time", "a number");
    if (i > 0 && !(time[i] > time[i - 1]))
      throw InputError(where, fmt::format("{} after {}", format_number(time[i]), format_number(time[i - 1])),
                       "time that increases");
  }
}

void check_period(const Recording& data, const std::vector<double>& time, const Range& range, double period) {
  for (std::size_t i = range.begin + 1; i < range.end; ++i) {
    const double step = time[i] - time[i - 1];
    // Times are decimal figures of limited length: their own rounding is no fault of the clock.
    const double rounding = 4e-16 * std::abs(time[i]);
    if (std::abs(step - period) > kPeriodTolerance * period + rounding)
      throw InputError(row_place(data, i), fmt::format("a step of {:.6g} s", step),
                       fmt::format("the sample_period of {} s within 1 % (leave it out for irregular clocks)",
                                   format_number(period)));
  }
}

Range range_of(const RecordingSpec& spec, const std::vector<double>& time) {
  if (time.size() < 2) throw InputError(printable(spec.file), fmt::format("{} sample", time.size()), "at least 2");
  // A range may name the end of the last sample's interval: 20 s of samples end at 19.99.
  const double first = time.front() - (time[1] - time[0]) * (1.0 + 1e-6);
  const double last = time.back() + (time.back() - time[time.size() - 2]) * (1.0 + 1e-6);
  const auto refuse = [&](const char* key, double value) {
    throw InputError(spec.where + "." + key, format_number(value) + " s",
                     fmt::format("a time within {}, {} to {} s", printable(spec.file), format_number(time.front()),
                                 format_number(time.back())));
  };
  if (spec.from && !(*spec.from >= first && *spec.from <= time.back())) refuse("from", *spec.from);
  if (spec.to && !(*spec.to >= time.front() && *spec.to <= last)) refuse("to", *spec.to);
  Range range{0, time.size()};
  if (spec.from)
    range.begin = static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), *spec.from) - time.begin());
  if (spec.to)
    range.end = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), *spec.to) - time.begin());
  if (range.end < range.begin + 2)
    throw InputError(spec.where, fmt::format("{} samples in the range", range.end - std::min(range.begin, range.end)),
                     "at least 2");
  return range;
}

class Checker {
 public:
  Checker(Scenario& scenario, const RecordingLimits& limits) : scenario_(scenario), limits_(limits) {}

  void run() {
    for (RecordingSpec& spec : scenario_.recordings) spec.data = load(spec);
    for (const RecordingSpec& spec : scenario_.recordings) check(spec);
    note_missing();
  }

 private:
  std::shared_ptr<const Recording> load(const RecordingSpec& spec) {
    const auto path = resolve(scenario_, spec.file);
    const auto parts = parts_of(scenario_, spec);
    for (const auto& [file, part] : parts)
      if (!is_there(file)) throw InputError(spec.where + ".file", "no file " + quoted(part.file), kRecordingKinds);
    std::string key = std::filesystem::weakly_canonical(path).string();
    for (const RecordingPart& part : spec.with) key += '\n' + part.file + '\n' + part.prefix;
    auto& shared = loaded_[key];
    if (shared) return shared;
    Recording data = read_recording(parts, limits_, column_use(scenario_.channels));
    for (const std::string& note : data.notes) scenario_.notes.push_back(printable(spec.file) + ": " + note);
    if (scenario_.channels.time.empty()) scenario_.channels.time = data.names.front();
    drop_unusable_cut_row(data, scenario_.channels, scenario_.notes);
    column_of(data, scenario_.channels.time, scenario_.file.string() + ": channels.time");
    shared = std::make_shared<const Recording>(std::move(data));
    check_clock(*shared, scenario_.channels.time, column_of(*shared, scenario_.channels.time, spec.where));
    return shared;
  }

  void check(const RecordingSpec& spec) {
    const Recording& data = *spec.data;
    const auto& time = column_of(data, scenario_.channels.time, spec.where);
    const Range range = range_of(spec, time);
    if (scenario_.sample_period) check_period(data, time, range, *scenario_.sample_period);
    for (const auto& [kind, joints] : scenario_.channels.of)
      for (const auto& [unused, channel] : joints) check_channel(kind, channel, spec, range);
  }

  void check_channel(ChannelKind kind, const ColumnSpec& channel, const RecordingSpec& spec, const Range& range) {
    const auto& values = column_of(*spec.data, channel.column, channel.where);
    std::size_t missing = 0;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const std::string_view name = channel.column;
      if (std::isnan(values[i])) {
        ++missing;
        if (kind == ChannelKind::command)
          throw InputError(row_place(*spec.data, i) + ": " + printable(name, 60), "no command", "a number");
      } else if (!std::isfinite(channel.scale * values[i] + channel.offset)) {
        throw InputError(row_place(*spec.data, i) + ": " + printable(name, 60), format_number(values[i]),
                         "a value that stays finite when scaled");
      }
    }
    if (kind == ChannelKind::position && missing == range.end - range.begin)
      throw InputError(spec.where, "no value of " + quoted(channel.column) + " in the range", "measured positions");
    if (missing > 0) missing_[spec.file][channel.column] += missing;
  }

  void note_missing() {
    for (const auto& [file, columns] : missing_) {
      std::size_t total = 0;
      std::string list;
      for (const auto& [column, count] : columns) {
        total += count;
        list += fmt::format("{}{} {}", list.empty() ? "" : ", ", printable(column, 60), count);
      }
      scenario_.notes.push_back(
          fmt::format("{}: {} missing value{} left out ({})", printable(file), total, total == 1 ? "" : "s", list));
    }
  }

  Scenario& scenario_;
  RecordingLimits limits_;
  std::map<std::string, std::shared_ptr<const Recording>> loaded_;
  std::map<std::string, std::map<std::string, std::size_t>> missing_;
};

}  // namespace

ColumnUse column_use(const ChannelSpecs& channels) {
  ColumnUse out;
  out.time = channels.time;
  for (const auto& [kind, joints] : channels.of)
    for (const auto& [unused, spec] : joints)
      (kind == ChannelKind::command ? out.commands : out.measured).insert(spec.column);
  return out;
}

std::vector<std::pair<std::filesystem::path, RecordingPart>> parts_of(const Scenario& scenario,
                                                                      const RecordingSpec& spec) {
  RecordingPart first;
  first.file = spec.file, first.log_times = spec.log_times;
  std::vector<std::pair<std::filesystem::path, RecordingPart>> out{{resolve(scenario, spec.file), first}};
  for (const RecordingPart& part : spec.with) out.emplace_back(resolve(scenario, part.file), part);
  return out;
}

void load_and_check_recordings(Scenario& scenario, const RecordingLimits& limits) { Checker(scenario, limits).run(); }

}  // namespace lacuna
