#include "study/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lacuna {
namespace {

/// Twice the mid-ranks (whole numbers) of the pooled sample, in its order.
std::vector<std::size_t> doubled_ranks(const std::vector<double>& pooled) {
  std::vector<std::size_t> order(pooled.size()), ranks(pooled.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return pooled[i] < pooled[j]; });
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && pooled[order[end]] == pooled[order[begin]]) ++end;
    for (std::size_t k = begin; k < end; ++k) ranks[order[k]] = begin + end + 1;  // 2 * mean of begin+1 .. end
  }
  return ranks;
}

}  // namespace

Quartiles quartiles_of(std::span<const double> values) {
  std::vector<double> sorted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double x) { return !std::isnan(x); });
  if (sorted.empty()) return {std::nan(""), std::nan(""), std::nan("")};
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(below);
    if (part == 0.0) return sorted[below];
    return sorted[below] + part * (sorted[below + 1] - sorted[below]);
  };
  return {at(0.25), at(0.5), at(0.75)};
}

double rank_sum_p(std::span<const double> a, std::span<const double> b) {
  if (a.empty() || b.empty()) return 1.0;
  std::vector<double> pooled(a.begin(), a.end());
  pooled.insert(pooled.end(), b.begin(), b.end());
  const std::vector<std::size_t> ranks = doubled_ranks(pooled);
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  // ways[n][s]: share of the divisions whose first sample has n members with rank sum s.
  std::vector<std::vector<double>> ways(a.size() + 1, std::vector<double>(total + 1, 0.0));
  ways[0][0] = 1.0;
  for (const std::size_t rank : ranks) {
    for (std::size_t n = a.size(); n-- > 0;) {
      for (std::size_t s = total - rank + 1; s-- > 0;) ways[n + 1][s + rank] += ways[n][s];
    }
  }
  const std::size_t seen =
      std::accumulate(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(a.size()), std::size_t{0});
  double all = 0.0, lower = 0.0, upper = 0.0;
  for (std::size_t s = 0; s <= total; ++s) {
    const double count = ways[a.size()][s];
    all += count;
    if (s <= seen) lower += count;
    if (s >= seen) upper += count;
  }
  return std::min(1.0, 2.0 * std::min(lower, upper) / all);
}

}  // namespace lacuna
