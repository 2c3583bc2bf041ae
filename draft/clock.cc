#include "draft/clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lacuna {
namespace {

/// Slower than this (s) nobody records an arm's motion; the next smaller unit is then meant.
constexpr double kSlowestPeriod = 0.5;
constexpr double kEvenWithin = 0.01;  // as scenarios/recording_check does

struct TimeUnit {
  const char* name;
  double seconds;
};
constexpr std::array kTimeUnits{TimeUnit{"s", 1.0}, TimeUnit{"ms", 1e-3}, TimeUnit{"us", 1e-6}, TimeUnit{"ns", 1e-9}};

}  // namespace

ClockGuess guess_clock(const std::vector<double>& time, const std::string& said) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time.size(); ++i) steps.push_back(time[i] - time[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double median = *middle;
  ClockGuess out;
  const auto named =
      std::find_if(kTimeUnits.begin(), kTimeUnits.end(), [&](const TimeUnit& unit) { return said == unit.name; });
  const auto fits = std::find_if(kTimeUnits.begin(), kTimeUnits.end(),
                                 [&](const TimeUnit& unit) { return median * unit.seconds <= kSlowestPeriod; });
  const TimeUnit unit = named != kTimeUnits.end() ? *named : fits != kTimeUnits.end() ? *fits : kTimeUnits.back();
  out.scale = unit.seconds, out.unit = unit.name;
  if (named != kTimeUnits.end()) {
    out.reason = "as its name says";
  } else if (unit.seconds == 1.0) {
    out.reason = fmt::format("samples lie {:.4g} apart: in s that is {:.4g} Hz", median, 1.0 / median);
  } else {
    out.sure = false;
    out.reason = fmt::format("samples lie {:.4g} apart: in s that would be {:.3g} Hz, in {} it is {:.4g} Hz", median,
                             1.0 / median, unit.name, 1.0 / (median * unit.seconds));
  }
  const auto [least, most] = std::minmax_element(steps.begin(), steps.end());
  out.period = median * unit.seconds, out.shortest = *least * unit.seconds, out.longest = *most * unit.seconds;
  const double rounding = 4e-16 * std::fabs(time.back()) * unit.seconds;
  const double slack = kEvenWithin * out.period + rounding;
  out.even = out.period - out.shortest <= slack && out.longest - out.period <= slack;
  out.start = time.front() * unit.seconds, out.end = time.back() * unit.seconds;
  return out;
}

}  // namespace lacuna
