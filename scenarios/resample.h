// A signal at other times than its own.
#pragma once

#include <vector>

namespace lacuna {

/// `signal` at other times by straight lines between its samples (NaN ones are bridged, ends held). Both times
/// increase.
std::vector<double> resampled(const std::vector<double>& time, const std::vector<double>& signal,
                              const std::vector<double>& at);

/// The last sample at or before each time, NaN before the first. Samples later by no more than the times' rounding
/// count as at that time: what two nodes of one loop stamp alike belongs together.
std::vector<double> held(const std::vector<double>& time, const std::vector<double>& signal,
                         const std::vector<double>& at);

/// How far two equal times may lie apart once they have been on different clocks, s.
double clock_rounding(double time);

}  // namespace lacuna
