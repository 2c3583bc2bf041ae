// The statistics of repeated runs: medians with quartiles, and whether two sets of runs differ.
#pragma once

#include <span>
#include <vector>

namespace lacuna {

struct Quartiles {
  double low = 0.0, median = 0.0, high = 0.0;
};

/// Linear between order statistics (type 7 of Hyndman and Fan, Am. Stat. 50, 1996). Infinity counts as larger than any
/// number, NaN is left out; all NaN when nothing is left.
Quartiles quartiles_of(std::span<const double> values);

/// Two-sided p-value of the rank-sum test (Wilcoxon 1945; Mann and Whitney 1947): how likely ranks as uneven as these
/// are if both samples come from one distribution. Exact for any ties, by counting the divisions of the pooled
/// mid-ranks. 1 where a sample is empty.
double rank_sum_p(std::span<const double> a, std::span<const double> b);

}  // namespace lacuna
