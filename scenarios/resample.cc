#include "scenarios/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lacuna {

std::vector<double> resampled(const std::vector<double>& time, const std::vector<double>& signal,
                              const std::vector<double>& at) {
  std::vector<double> times, values;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (std::isfinite(signal[i])) times.push_back(time[i]), values.push_back(signal[i]);
  std::vector<double> out(at.size(), values.empty() ? 0.0 : values.front());
  if (times.size() < 2) return out;
  std::size_t i = 0;
  for (std::size_t k = 0; k < at.size(); ++k) {
    while (i + 2 < times.size() && times[i + 1] <= at[k]) ++i;
    const double share = std::clamp((at[k] - times[i]) / (times[i + 1] - times[i]), 0.0, 1.0);
    out[k] = share == 0.0 ? values[i] : values[i] + share * (values[i + 1] - values[i]);
  }
  return out;
}

double clock_rounding(double time) {
  // Half a nanosecond, the grain of ROS's stamps; or two roundings of a time in seconds since 1970.
  return 5e-10 + 4e-16 * std::fabs(time);
}

std::vector<double> held(const std::vector<double>& time, const std::vector<double>& signal,
                         const std::vector<double>& at) {
  std::vector<double> out(at.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t next = 0;
  for (std::size_t k = 0; k < at.size(); ++k) {
    while (next < time.size() && time[next] <= at[k] + clock_rounding(at[k])) ++next;
    if (next > 0) out[k] = signal[next - 1];
  }
  return out;
}

}  // namespace lacuna
