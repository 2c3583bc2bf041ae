// Columns with clocks of their own (topics of a bag, several files) brought onto one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/recording.h"

namespace lacuna {

/// Columns that share a clock.
struct Track {
  std::string source;        ///< topic or file, for messages
  std::string clock;         ///< name of its time column
  std::vector<double> time;  ///< s, increasing; at least one
  /// ns from 1970 (or whatever the bag's clock counts from) to time 0; absent where only the file knows
  std::optional<std::int64_t> epoch_ns;
  bool command = false;  ///< held unless told otherwise
  bool state = false;    ///< a clock to prefer
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< one per name, as long as `time`
};

/// A topic that could not be read; an error as soon as one of its columns is asked for.
struct UnreadTopic {
  std::string topic, where, found, expected;
};

struct TrackSet {
  std::vector<Track> tracks;
  std::vector<UnreadTopic> unread;
  std::vector<std::string> notes;
};

/// Index of the track whose clock becomes the recording's: the one named `clock`; else of those that say states of
/// joints the one with most samples, else the one with most. `tracks` is not empty.
std::size_t reference_track(const std::vector<Track>& tracks, const std::string& clock);

/// Moves the times of `other` onto the clock of `reference`: clocks that count from one epoch by themselves, others by
/// `offset` (s, added; 0 where neither knows an epoch). Throws InputError where one knows its epoch, the other does not
/// and no offset is given.
void shift_clock(Track& other, const Track& reference, std::optional<double> offset, const std::string& where);

/// One table on the clock of tracks[reference], whose samples are its rows. Commands (by `use`, else by their type) are
/// held; all else lies on straight lines between samples, missing where a neighbour is missing or the samples are more
/// than five of their usual intervals apart. Where `use` names columns, the rows are those of the span that all used
/// tracks have in common, a command's beginning with its first sample; else what a track does not cover is missing.
/// Notes say what was brought where and what was cut off. The first column is the time: `time_name`.
/// Throws InputError for names that come twice, spans that have nothing in common, more columns than the limit.
Recording join_tracks(const std::vector<Track>& tracks, std::size_t reference, const std::string& time_name,
                      const ColumnUse& use, const std::string& file, const RecordingLimits& limits);

}  // namespace lacuna
