#include "physics/measured_motion.h"

#include <algorithm>
#include <boost/math/interpolators/cubic_hermite.hpp>
#include <boost/math/interpolators/makima.hpp>
#include <cmath>

namespace lacuna {
namespace {

constexpr double kEven = 0.01;      // of the period
constexpr double kAtRest = 3.0;     // standard errors of a speed
constexpr std::size_t kFewest = 5;  // samples that a cubic interpolation needs

/// Samples that are there.
struct Present {
  std::vector<double> time, value, slope;
};

Present present(const std::vector<double>& time, const std::vector<double>& value, const std::vector<double>& slope) {
  Present out;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!std::isfinite(value[i]) || (!slope.empty() && !std::isfinite(slope[i]))) continue;
    out.time.push_back(time[i]);
    out.value.push_back(value[i]);
    if (!slope.empty()) out.slope.push_back(slope[i]);
  }
  return out;
}

/// A smooth signal at other times by cubics; where `slope` is given, those are its slopes.
std::vector<double> smooth_at(const std::vector<double>& time, const std::vector<double>& value,
                              const std::vector<double>& slope, const std::vector<double>& at) {
  Present p = present(time, value, slope);
  if (p.time.size() < kFewest) return resampled(time, value, at);
  const double first = p.time.front(), last = p.time.back();
  std::vector<double> out(at.size());
  const auto fill = [&](const auto& curve) {
    for (std::size_t k = 0; k < at.size(); ++k) out[k] = curve(std::clamp(at[k], first, last));
  };
  using boost::math::interpolators::cubic_hermite;
  using boost::math::interpolators::makima;
  if (slope.empty()) {
    fill(makima<std::vector<double>>(std::move(p.time), std::move(p.value)));
  } else {
    fill(cubic_hermite<std::vector<double>>(std::move(p.time), std::move(p.value), std::move(p.slope)));
  }
  return out;
}

/// Central differences; the ends repeat their neighbours.
std::vector<double> slope_of(const std::vector<double>& x, double rate) {
  const std::size_t n = x.size();
  std::vector<double> out(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) out[i] = 0.5 * rate * (x[i + 1] - x[i - 1]);
  if (n > 2) out.front() = out[1], out.back() = out[n - 2];
  return out;
}

std::vector<double> bend_of(const std::vector<double>& x, double rate) {
  const std::size_t n = x.size();
  std::vector<double> out(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) out[i] = rate * rate * (x[i + 1] - 2.0 * x[i] + x[i - 1]);
  if (n > 2) out.front() = out[1], out.back() = out[n - 2];
  return out;
}

std::vector<double> directions(const std::vector<double>& v, double error) {
  std::vector<double> out;
  double last = 0.0;
  for (const double speed : v) {
    if (std::fabs(speed) > kAtRest * error) last = speed > 0.0 ? 1.0 : -1.0;
    out.push_back(last);
  }
  return out;
}

double known(const std::vector<double>& noise, std::size_t j) {
  return j < noise.size() && std::isfinite(noise[j]) ? noise[j] : 0.0;
}

}  // namespace

bool is_even(const std::vector<double>& time) {
  if (time.size() < 3) return true;
  const double period = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  for (std::size_t i = 1; i < time.size(); ++i)
    if (std::fabs(time[i] - time[i - 1] - period) > kEven * period) return false;
  return true;
}

std::vector<double> even_times(const std::vector<double>& time) {
  std::vector<double> out(time.size());
  const double period = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = time.front() + period * static_cast<double>(i);
  return out;
}

FilterGain filter_gain(const ZeroPhaseLowPass& filter, int passes) {
  std::vector<double> x(4 * filter.reach() + 3, 0.0);
  x[x.size() / 2] = 1.0;
  for (int k = 0; k < passes; ++k) filter.apply(x);
  FilterGain out{0.0, 0.0};
  for (const double h : x) out.value += h * h;
  for (const double h : slope_of(x, 1.0)) out.slope += h * h;
  return {std::sqrt(out.value), std::sqrt(out.slope)};
}

MeasuredMotion measured_motion(const RawMotion& raw, double cutoff_hz) {
  const std::size_t joints = raw.position.size(), n = raw.time.size();
  MeasuredMotion out;
  const bool even = is_even(raw.time);
  out.time = even_times(raw.time);
  out.rate = static_cast<double>(n - 1) / (raw.time.back() - raw.time.front());
  const ZeroPhaseLowPass filter(cutoff_hz, out.rate);
  const FilterGain gain = filter_gain(filter, 1);
  const std::vector<double> nothing(n, 0.0);
  for (std::size_t j = 0; j < joints; ++j) {
    out.q.push_back(nothing), out.v.push_back(nothing), out.a.push_back(nothing), out.v_error.push_back(0.0);
    out.direction.push_back(nothing);
    if (raw.position[j].empty()) continue;
    const bool rated = j < raw.velocity.size() && !raw.velocity[j].empty();
    out.q[j] = even ? resampled(out.time, raw.position[j], out.time)
                    : smooth_at(raw.time, raw.position[j], rated ? raw.velocity[j] : std::vector<double>{}, out.time);
    filter.apply(out.q[j]);
    if (rated) {
      out.v[j] = resampled(even ? out.time : raw.time, raw.velocity[j], out.time);
      filter.apply(out.v[j]);
      out.a[j] = slope_of(out.v[j], out.rate);
      out.v_error[j] = gain.value * known(raw.velocity_noise, j);
    } else {
      out.v[j] = slope_of(out.q[j], out.rate);
      out.a[j] = bend_of(out.q[j], out.rate);
      out.v_error[j] = gain.slope * out.rate * known(raw.position_noise, j);
    }
    out.direction[j] = directions(out.v[j], out.v_error[j]);
  }
  return out;
}

}  // namespace lacuna
