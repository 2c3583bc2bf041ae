// What the time column of a recording says: its unit, and how even its clock is.
#pragma once

#include <string>
#include <vector>

namespace lacuna {

struct ClockGuess {
  double scale = 1.0;                    ///< s per unit of the column
  std::string unit = "s";                ///< "s", "ms", "us", "ns"
  std::string reason;                    ///< why this unit
  bool sure = true;                      ///< the unit is said, or only one makes sense
  double period = 0.0;                   ///< s, median spacing
  double shortest = 0.0, longest = 0.0;  ///< s, spacings
  bool even = false;                     ///< every spacing within 1 % of the median: fit for `sample_period`
  double start = 0.0, end = 0.0;         ///< s
};

/// `time` increases and has two samples at least; `said` is the unit in the column's name, "" where there is none.
ClockGuess guess_clock(const std::vector<double>& time, const std::string& said);

}  // namespace lacuna
