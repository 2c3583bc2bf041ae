// A recording: named columns of numbers over time, as loaded from CSV, MATLAB .mat or a bag of ROS 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace lacuna {

struct Recording {
  std::string file;                          ///< as written in the scenario
  std::vector<std::string> names;            ///< column names, unique
  std::vector<std::vector<double>> columns;  ///< one per name, equal lengths; NaN where a value is missing
  std::size_t missing = 0;                   ///< values that were empty, `nan`, or cut off with the file's last line
  bool cut = false;                          ///< the file's last line stopped in mid-line
  bool joined = false;                       ///< several clocks were brought onto one: rows are no lines of a file
  std::vector<std::string> notes = {};       ///< what loading left out or brought onto another clock, a line each

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  /// Index of a column or -1.
  int find(const std::string& name) const;
};

/// Limits against hostile files; each is named in the error that it raises.
struct RecordingLimits {
  std::uintmax_t bytes = std::uintmax_t{4} << 30;  ///< larger files are refused unread
  std::size_t columns = 4096;
  std::size_t line_bytes = 1 << 20;
};

/// What columns are for: matters where a recording has several clocks (topics of a bag, several files).
struct ColumnUse {
  std::string time = {};                ///< column whose clock is the recording's; "": the first file's own choice
  std::set<std::string> commands = {};  ///< held from one sample to the next
  std::set<std::string> measured = {};  ///< by straight lines between samples
};

/// One of the files that a recording is made of.
struct RecordingPart {
  std::string file = {};                    ///< as written, for messages
  std::string prefix = {};                  ///< put before the names of its columns
  std::string time = {};                    ///< its time column; "": ColumnUse::time where it has that, else its first
  std::optional<double> clock_offset = {};  ///< s, added to its times to have them on the first file's clock
  bool log_times = false;                   ///< of a bag: the times at which messages were received, not their headers'

  bool operator==(const RecordingPart&) const = default;
};

/// Loads `.csv` (header line, comma separated), `.mat` (numeric vectors of one length, or one struct of them), or a bag
/// of ROS 2: a folder with metadata.yaml, or one of its files (`.db3`, `.mcap`), whose topics are brought onto one
/// clock (clocks.h). A short or empty field is a missing value (NaN, counted). Text that is no number is an InputError
/// with file, line, column. Infinite values are an InputError. CSV: at least a million rows a second.
std::shared_ptr<const Recording> load_recording(const std::filesystem::path& file, const std::string& shown_name,
                                                const RecordingLimits& limits = {}, const ColumnUse& use = {});

/// Writes columns as CSV, shortest decimal form that reads back to the same bits.
void write_csv(const std::filesystem::path& file, const Recording& recording);

}  // namespace lacuna
