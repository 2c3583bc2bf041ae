#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/svg.h"

namespace lacuna {
namespace {

/// Sizes beyond which differences of doubles would overflow.
constexpr double kLargest = 1e300;

/// The smallest of 1, 2, 5 times a power of ten that is at least `raw`.
double nice_step(double raw) {
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

/// A range that can be drawn.
void widen(double& low, double& high) {
  if (!std::isfinite(low) || !std::isfinite(high) || low > high) low = 0.0, high = 1.0;
  low = std::clamp(low, -kLargest, kLargest);
  high = std::clamp(high, -kLargest, kLargest);
  const double size = std::max(std::fabs(low), std::fabs(high));
  if (size < 1e-300) low = -1.0, high = 1.0;
  // Constant down to rounding: its last digits are no signal.
  else if (high - low < 1e-9 * size)
    low -= 0.05 * size, high += 0.05 * size;
}

}  // namespace

Axis1d make_axis(double low, double high, int most_ticks, bool tight) {
  widen(low, high);
  const double step = nice_step((high - low) / std::max(most_ticks, 1));
  Axis1d axis;
  axis.low = tight ? low : std::floor(low / step + 1e-9) * step;
  axis.high = tight ? high : std::ceil(high / step - 1e-9) * step;
  const double size = std::max(std::fabs(axis.low), std::fabs(axis.high));
  const int decade = static_cast<int>(std::floor(std::log10(size)));
  if (decade >= 5 || decade < -1) axis.exponent = static_cast<int>(std::floor(decade / 3.0)) * 3;
  const double unit = std::pow(10.0, axis.exponent);
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step / unit) + 1e-9)), 0, 12);
  const double first = std::ceil(axis.low / step - 1e-6), last = std::floor(axis.high / step + 1e-6);
  for (double k = first; k <= last && axis.ticks.size() < 64; k += 1.0) {
    const double tick = k == 0.0 ? 0.0 : k * step;
    axis.ticks.push_back(tick);
    axis.labels.push_back(fmt::format("{:.{}f}", tick / unit, decimals));
  }
  return axis;
}

Axis1d make_log_axis(double low, double high, int most_ticks) {
  if (!std::isfinite(low) || !std::isfinite(high) || low > high) low = 0.0, high = 1.0;
  Axis1d axis;
  axis.low = std::floor(low), axis.high = std::ceil(high);
  if (axis.high <= axis.low) axis.high = axis.low + 1.0;
  const double step = std::max(1.0, std::ceil((axis.high - axis.low) / std::max(most_ticks, 1)));
  for (double decade = axis.low; decade <= axis.high; decade += step) {
    axis.ticks.push_back(decade);
    const bool plain = decade >= -2 && decade <= 4;
    axis.labels.push_back(plain ? fmt::format("{:g}", std::pow(10.0, decade)) : fmt::format("1e{:.0f}", decade));
  }
  return axis;
}

std::vector<std::size_t> decimate(std::span<const double> y, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t n = y.size();
  if (n <= most || most < 2) {
    for (std::size_t i = 0; i < n; ++i) out.push_back(i);
    return out;
  }
  const std::size_t stretches = most / 2;
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * n / stretches, end = (s + 1) * n / stretches;
    std::size_t low = begin, high = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (!std::isfinite(y[low]) || y[i] < y[low]) low = i;
      if (!std::isfinite(y[high]) || y[i] > y[high]) high = i;
    }
    out.push_back(std::min(low, high));
    if (low != high) out.push_back(std::max(low, high));
  }
  return out;
}

}  // namespace lacuna
