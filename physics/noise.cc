#include "physics/noise.h"

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

/// No transducer is credited with less than this share of the range that it was seen to cover.
constexpr double kFinestNoise = 1e-6;
constexpr double kSameLevel = 1e-9;         ///< of the range: nearer values differ by rounding
constexpr std::ptrdiff_t kLevelsAgain = 8;  ///< levels that are read more than once are enough to be levels
constexpr double kNearlyWhole = 0.15;       ///< of a step, from a multiple of it
constexpr double kMostGaps = 0.95;          ///< share of the gaps that are multiples

/// One value that a reading takes.
struct Level {
  double value;
  int visits;
};

std::vector<Level> levels_of(const std::vector<double>& signal) {
  std::vector<double> values;
  for (const double x : signal) {
    if (std::isfinite(x)) values.push_back(x);
  }
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double same = kSameLevel * (values.back() - values.front());
  std::vector<Level> out;
  for (const double x : values) {
    if (out.empty() || x - out.back().value > same)
      out.push_back({x, 1});
    else
      ++out.back().visits;
  }
  return out;
}

}  // namespace

double noise_from_differences(const std::vector<double>& time, const std::vector<double>& signal) {
  // Weights of the sixth divided difference: zero for any polynomial of fifth degree, whatever the spacing. Motion of a
  // twentieth of the sampling rate passes at 3e-5 of its size, white noise whole.
  constexpr std::size_t kOrder = 6;
  std::vector<double> squares;
  std::vector<bool> moves;
  for (std::size_t i = kOrder; i < signal.size(); ++i) {
    double value = 0.0, norm = 0.0;
    bool changes = false;
    for (std::size_t a = i - kOrder; a <= i; ++a) {
      double weight = 1.0;
      for (std::size_t b = i - kOrder; b <= i; ++b) {
        if (b != a) weight *= (time[i] - time[i - kOrder]) / (time[a] - time[b]);
      }
      value += weight * signal[a];
      norm += weight * weight;
      changes = changes || signal[a] != signal[i];
    }
    if (!std::isfinite(value)) continue;
    squares.push_back(value * value / norm);
    moves.push_back(changes);
  }
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double x : signal) {
    if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  }
  const double floor = kFinestNoise * std::max(high - low, 0.0);
  constexpr std::size_t kBlock = 25;
  std::vector<double> blocks;
  for (std::size_t i = 0; i + kBlock <= squares.size(); i += kBlock) {
    double sum = 0.0;
    bool any = false;
    for (std::size_t k = i; k < i + kBlock; ++k) sum += squares[k], any = any || moves[k];
    // A reading that stands still says nothing of its noise; what its differences leave is rounding.
    if (any) blocks.push_back(sum / kBlock);
  }
  if (blocks.empty()) return floor > 0.0 ? floor : std::nan("");
  std::nth_element(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() / 2), blocks.end());
  // Neighbouring differences of white noise correlate as C(12, 6-k)/C(12, 6): a block of 25 holds 25/3.17 degrees of
  // freedom, and the median of its mean square lies below the mean by the factor of Wilson and Hilferty.
  constexpr double kFreedom = static_cast<double>(kBlock) / 3.17, kRoot = 1.0 - 2.0 / (9.0 * kFreedom);
  return std::max(floor, std::sqrt(blocks[blocks.size() / 2] / (kRoot * kRoot * kRoot)));
}

double quantisation_step(const std::vector<double>& signal) {
  const std::vector<Level> levels = levels_of(signal);
  if (levels.size() < 2) return 0.0;
  // Levels are come back to; a smooth motion's values are not, though equal steps may lie between them.
  const auto again = std::count_if(levels.begin(), levels.end(), [](const Level& l) { return l.visits > 1; });
  if (again < std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(levels.size() / 2), 2, kLevelsAgain)) return 0.0;
  std::vector<double> gaps;
  for (std::size_t k = 1; k < levels.size(); ++k) gaps.push_back(levels[k].value - levels[k - 1].value);
  const double least = *std::min_element(gaps.begin(), gaps.end());
  double sum = 0.0, count = 0.0;  // of single steps: a logger that prints few digits writes them unequal
  for (const double gap : gaps) {
    if (gap < 1.5 * least) sum += gap, count += 1.0;
  }
  const double step = sum / count;
  const auto whole = std::count_if(gaps.begin(), gaps.end(), [&](double gap) {
    return std::fabs(gap / step - std::round(gap / step)) < kNearlyWhole;
  });
  return static_cast<double>(whole) >= kMostGaps * static_cast<double>(gaps.size()) ? step : 0.0;
}

double noise_of(const std::vector<double>& time, const std::vector<double>& signal) {
  const double rounding = quantisation_step(signal) / std::sqrt(12.0), seen = noise_from_differences(time, signal);
  if (!(rounding > 0.0)) return seen;
  return std::isfinite(seen) ? std::max(seen, rounding) : rounding;
}

}  // namespace lacuna
