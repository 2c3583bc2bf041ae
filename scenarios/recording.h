// A recording: named columns of numbers over time, as loaded from CSV or MATLAB .mat.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace lacuna {

struct Recording {
  std::string file;                          ///< as written in the scenario
  std::vector<std::string> names;            ///< column names, unique
  std::vector<std::vector<double>> columns;  ///< one per name, equal lengths; NaN where a value is missing
  std::size_t missing = 0;                   ///< values that were empty, `nan`, or cut off with the file's last line
  bool cut = false;                          ///< the file's last line stopped in mid-line

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

/// Loads `.csv` (header line, comma separated) or `.mat` (v5, v7: numeric vectors of one length, or one struct of
/// them). A short or empty field is a missing value (NaN, counted). Text that is no number is an InputError with file,
/// line, column. Infinite values are an InputError. Reads at least a million rows a second.
std::shared_ptr<const Recording> load_recording(const std::filesystem::path& file, const std::string& shown_name,
                                                const RecordingLimits& limits = {});

/// Writes columns as CSV, shortest decimal form that reads back to the same bits.
void write_csv(const std::filesystem::path& file, const Recording& recording);

}  // namespace lacuna
