#include "scenarios/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "scenarios/error.h"
#include "scenarios/resample.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr double kNanosecond = 1e-9;
/// A stretch without samples longer than this many usual intervals is no straight line.
constexpr double kLongestGap = 5.0;
/// A last command older than this (s) at the end is worth a note.
constexpr double kStaleCommand = 1.0;

enum class Purpose { unused, command, measured };

Purpose purpose_of(const std::string& name, const Track& track, const ColumnUse& use) {
  if (use.commands.count(name) > 0) return Purpose::command;
  if (use.measured.count(name) > 0) return Purpose::measured;
  const bool told = !use.commands.empty() || !use.measured.empty();
  return told ? Purpose::unused : track.command ? Purpose::command : Purpose::measured;
}

double usual_interval(const std::vector<double>& time) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time.size(); ++i) steps.push_back(time[i] - time[i - 1]);
  if (steps.empty()) return 0.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Straight lines, where there is something to draw them between.
std::vector<double> lines(const Track& track, const std::vector<double>& values, const std::vector<double>& at) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double>& time = track.time;
  const double widest = kLongestGap * usual_interval(time) * (1.0 + 1e-6);
  std::vector<double> out = resampled(time, values, at);
  std::size_t i = 0;  // the last sample at or before
  for (std::size_t k = 0; k < at.size(); ++k) {
    const double slack = clock_rounding(at[k]);
    while (i + 1 < time.size() && time[i + 1] <= at[k] + slack) ++i;
    if (std::fabs(time[i] - at[k]) <= slack) {
      out[k] = values[i];
    } else if (time[i] > at[k] || i + 1 == time.size() || time[i + 1] - time[i] > widest || std::isnan(values[i]) ||
               std::isnan(values[i + 1])) {
      out[k] = kMissing;
    }
  }
  return out;
}

struct Span {
  double from = -std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
};

std::string seconds(double t) { return fmt::format("{:.12g}", t); }

class Joiner {
 public:
  Joiner(const std::vector<Track>& tracks, std::size_t reference, const ColumnUse& use, const std::string& file)
      : tracks_(tracks), reference_(tracks[reference]), use_(use), file_(file) {}

  Recording run(const std::string& time_name, const RecordingLimits& limits) {
    choose_rows();
    Recording out;
    out.file = file_, out.joined = true;
    add(out, time_name, rows_, limits);
    for (const Track& track : tracks_) {
      for (std::size_t c = 0; c < track.names.size(); ++c) add(out, track.names[c], column(track, c), limits);
      note(track, out);
    }
    if (cut_) out.notes.push_back(cut_text());
    for (const auto& values : out.columns)
      out.missing +=
          static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double x) { return std::isnan(x); }));
    return out;
  }

 private:
  bool is_reference(const Track& track) const { return &track == &reference_; }

  bool serves(const Track& track, Purpose purpose) const {
    return std::any_of(track.names.begin(), track.names.end(),
                       [&](const std::string& name) { return purpose_of(name, track, use_) == purpose; });
  }

  /// The samples of the reference that every used track covers.
  void choose_rows() {
    rows_ = reference_.time;
    if (use_.commands.empty() && use_.measured.empty()) return;
    Span common;
    for (const Track& track : tracks_) {
      if (is_reference(track)) continue;
      const bool measured = serves(track, Purpose::measured);
      if (!measured && !serves(track, Purpose::command)) continue;
      check_overlap(track, measured);
      common.from = std::max(common.from, track.time.front());
      if (measured) common.to = std::min(common.to, track.time.back());
    }
    std::erase_if(rows_,
                  [&](double t) { return t < common.from - clock_rounding(t) || t > common.to + clock_rounding(t); });
    cut_ = rows_.size() < reference_.time.size();
    if (rows_.size() < 2)
      throw InputError(printable(file_),
                       fmt::format("{} sample{} of {} in the span that all clocks have in common", rows_.size(),
                                   rows_.size() == 1 ? "" : "s", printable(reference_.source, 80)),
                       "at least 2");
  }

  void check_overlap(const Track& track, bool measured) const {
    const bool late = track.time.front() > reference_.time.back(),
               early = measured && track.time.back() < reference_.time.front();
    // A command given long before still holds; but one of another day is another clock.
    const double length = reference_.time.back() - reference_.time.front();
    const bool elsewhere = !measured && track.time.back() < reference_.time.front() - std::max(60.0, length);
    if (!late && !early && !elsewhere) return;
    throw InputError(
        printable(file_),
        fmt::format("{} from {} to {} s and {} from {} to {} s, on the clock of the latter",
                    printable(track.source, 80), seconds(track.time.front()), seconds(track.time.back()),
                    printable(reference_.source, 80), seconds(reference_.time.front()),
                    seconds(reference_.time.back())),
        "spans that overlap (clock_offset moves a file's clock; stamps: log takes a bag's times of receipt)");
  }

  std::vector<double> column(const Track& track, std::size_t c) const {
    const std::vector<double>& values = track.columns[c];
    if (is_reference(track)) {
      std::vector<double> out;
      for (std::size_t i = 0, row = 0; i < values.size() && row < rows_.size(); ++i)
        if (track.time[i] == rows_[row]) out.push_back(values[i]), ++row;
      return out;
    }
    return purpose_of(track.names[c], track, use_) == Purpose::command ||
                   (track.command && use_.measured.count(track.names[c]) == 0)
               ? held(track.time, values, rows_)
               : lines(track, values, rows_);
  }

  void add(Recording& out, const std::string& name, std::vector<double> values, const RecordingLimits& limits) {
    if (!names_.insert(name).second)
      throw InputError(printable(file_), "the column " + quoted(name) + " twice",
                       "each column name once (prefix: sets a file's apart)");
    if (names_.size() > limits.columns)
      throw InputError(printable(file_), fmt::format("more than {} columns", limits.columns), "fewer columns");
    out.names.push_back(name);
    out.columns.push_back(std::move(values));
  }

  void note(const Track& track, Recording& out) const {
    if (is_reference(track) || (!serves(track, Purpose::command) && !serves(track, Purpose::measured))) return;
    const bool command = serves(track, Purpose::command), measured = serves(track, Purpose::measured);
    out.notes.push_back(fmt::format("{}: brought onto the clock of {}, {}", printable(track.source, 80),
                                    printable(reference_.source, 80),
                                    command && measured ? "commands held, all else by straight lines"
                                    : command           ? "held from sample to sample"
                                                        : "by straight lines between samples"));
    const double since = rows_.back() - track.time.back();
    if (command && since > kStaleCommand)
      out.notes.push_back(fmt::format("{}: its last command comes {} s before the end and is held until there",
                                      printable(track.source, 80), seconds(since)));
  }

  std::string cut_text() const {
    return fmt::format("only the span that all used clocks have in common is used, {} to {} s of {} to {} s",
                       seconds(rows_.front()), seconds(rows_.back()), seconds(reference_.time.front()),
                       seconds(reference_.time.back()));
  }

  const std::vector<Track>& tracks_;
  const Track& reference_;
  const ColumnUse& use_;
  const std::string& file_;
  std::vector<double> rows_;
  bool cut_ = false;
  std::set<std::string> names_;
};

}  // namespace

std::size_t reference_track(const std::vector<Track>& tracks, const std::string& clock) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track &track = tracks[i], &so_far = tracks[best];
    if (!clock.empty() && track.clock == clock) return i;
    if (track.state != so_far.state ? track.state : track.time.size() > so_far.time.size()) best = i;
  }
  return best;
}

void shift_clock(Track& other, const Track& reference, std::optional<double> offset, const std::string& where) {
  double shift = offset.value_or(0.0);
  if (other.epoch_ns && reference.epoch_ns) {
    const double whole = static_cast<double>(*other.epoch_ns / 1'000'000'000 - *reference.epoch_ns / 1'000'000'000);
    shift += whole +
             kNanosecond * static_cast<double>(*other.epoch_ns % 1'000'000'000 - *reference.epoch_ns % 1'000'000'000);
  } else if ((other.epoch_ns || reference.epoch_ns) && !offset) {
    const Track& dated = other.epoch_ns ? other : reference;
    throw InputError(
        where, fmt::format("no clock_offset, but only {} says what its clock counts from", printable(dated.source, 80)),
        fmt::format("clock_offset: s to add to the times of {} ({} would let both begin together)",
                    printable(other.source, 80), format_number(reference.time.front() - other.time.front())));
  }
  if (shift == 0.0) return;
  for (double& t : other.time) t += shift;
}

Recording join_tracks(const std::vector<Track>& tracks, std::size_t reference, const std::string& time_name,
                      const ColumnUse& use, const std::string& file, const RecordingLimits& limits) {
  return Joiner(tracks, reference, use, file).run(time_name, limits);
}

}  // namespace lacuna
