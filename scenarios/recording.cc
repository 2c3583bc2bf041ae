#include "scenarios/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "scenarios/bag.h"
#include "scenarios/clocks.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_formats.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using Part = std::pair<std::filesystem::path, RecordingPart>;

/// A clock whose figures are as large as this (s) counts from 1970, as date +%s does: it is after 2001.
constexpr double kUnixTime = 1e9;
const char* const kTimeOfBag = "time";

Recording read_table(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  check_regular_file(file, name, kRecordingKinds, limits.bytes);
  if (extension == ".csv") return read_csv(file, name, limits);
  if (extension == ".mat") return read_mat(file, name, limits);
  throw InputError(printable(name), "a file ending in " + quoted(extension), kRecordingKinds);
}

/// A table's columns as a track. What a logger cut off in its last line is no sample.
Track track_of_table(Recording data, const RecordingPart& part, const ColumnUse& use) {
  const std::string clock = !part.time.empty() ? part.time : data.find(use.time) >= 0 ? use.time : data.names.front();
  const int at = data.find(clock);
  if (at < 0) throw InputError(printable(part.file), "no column " + quoted(clock), "its time: " + one_of(data.names));
  const auto last_incomplete = [&] {
    return std::any_of(data.columns.begin(), data.columns.end(), [](const auto& c) { return std::isnan(c.back()); });
  };
  if (data.cut && data.rows() > 1 && last_incomplete())
    for (auto& column : data.columns) column.pop_back();
  Track out;
  out.source = part.file, out.clock = clock;
  for (std::size_t c = 0; c < data.names.size(); ++c) {
    if (static_cast<int>(c) == at) {
      out.time = std::move(data.columns[c]);
    } else {
      out.names.push_back(std::move(data.names[c]));
      out.columns.push_back(std::move(data.columns[c]));
    }
  }
  for (std::size_t i = 0; i < out.time.size(); ++i)
    if (!(i == 0 ? std::isfinite(out.time[0]) : out.time[i] > out.time[i - 1]))
      throw InputError(fmt::format("{}: {}, value {}", printable(part.file), printable(clock, 60), i + 1),
                       std::isnan(out.time[i]) ? "no time" : format_number(out.time[i]), "time that increases");
  if (out.time.front() >= kUnixTime) out.epoch_ns = 0;
  return out;
}

/// The tracks of one file, its prefix put before every column.
TrackSet tracks_of(const Part& part, const RecordingLimits& limits, const ColumnUse& use) {
  const auto& [path, said] = part;
  TrackSet out;
  if (is_bag(path)) {
    out = read_bag(path, said.file, limits, said.log_times);
  } else {
    if (said.log_times) throw InputError(printable(said.file), "stamps: log", "a bag, where it is given");
    out.tracks.push_back(track_of_table(read_table(path, said.file, limits), said, use));
  }
  for (Track& track : out.tracks)
    for (std::string& name : track.names) name.insert(0, said.prefix);
  for (UnreadTopic& topic : out.unread) topic.topic.insert(0, said.prefix);
  return out;
}

/// A bag's own clock is called as it is asked for, so that it may stand beside tables; a topic's name must be a
/// topic's.
std::string name_of_bags_time(const std::string& wanted) {
  return wanted.empty() || wanted.front() == '/' ? kTimeOfBag : wanted;
}

/// A column that is asked for and whose topic could not be read: the reason why it is not there.
void refuse_unread(const TrackSet& set, const ColumnUse& use) {
  for (const UnreadTopic& unread : set.unread)
    for (const auto* names : {&use.commands, &use.measured})
      for (const std::string& name : *names)
        if (name.starts_with(unread.topic + "/")) throw InputError(unread.where, unread.found, unread.expected);
}

}  // namespace

int Recording::find(const std::string& name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

Recording read_recording(const std::vector<Part>& parts, const RecordingLimits& limits, const ColumnUse& use) {
  const auto& [path, first] = parts.front();
  if (parts.size() == 1 && !is_bag(path) && !first.log_times && first.prefix.empty())
    return read_table(path, first.file, limits);
  TrackSet all = tracks_of(parts.front(), limits, use);
  const bool bag = is_bag(path);
  const std::size_t reference = reference_track(all.tracks, first.time.empty() ? use.time : first.time);
  const Track clock = all.tracks[reference];  // a copy: the list grows
  const std::string& wanted = first.time.empty() ? use.time : first.time;
  const std::string time_name = bag && clock.clock != wanted ? name_of_bags_time(wanted) : clock.clock;
  // A bag's other topics count from its own epoch, whatever is said of other files.
  for (std::size_t i = 0; i < all.tracks.size(); ++i)
    if (i != reference) shift_clock(all.tracks[i], clock, std::nullopt, printable(first.file));
  for (std::size_t p = 1; p < parts.size(); ++p) {
    TrackSet more = tracks_of(parts[p], limits, use);
    for (Track& track : more.tracks) {
      shift_clock(track, clock, parts[p].second.clock_offset, printable(parts[p].second.file));
      all.tracks.push_back(std::move(track));
    }
    std::move(more.unread.begin(), more.unread.end(), std::back_inserter(all.unread));
    std::move(more.notes.begin(), more.notes.end(), std::back_inserter(all.notes));
  }
  refuse_unread(all, use);
  Recording out = join_tracks(all.tracks, reference, time_name, use, first.file, limits);
  out.notes.insert(out.notes.begin(), all.notes.begin(), all.notes.end());
  return out;
}

Recording read_recording(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits,
                         const ColumnUse& use) {
  RecordingPart part;
  part.file = name;
  return read_recording({{file, part}}, limits, use);
}

std::shared_ptr<const Recording> load_recording(const std::filesystem::path& file, const std::string& shown_name,
                                                const RecordingLimits& limits, const ColumnUse& use) {
  return std::make_shared<const Recording>(read_recording(file, shown_name, limits, use));
}

}  // namespace lacuna
