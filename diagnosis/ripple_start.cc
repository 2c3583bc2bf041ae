#include "diagnosis/ripple_start.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "ga/problem.h"

namespace lacuna {
namespace {

constexpr std::size_t kStarts = 3;
constexpr double kMostNumbers = 4096;  ///< of n that are tried
constexpr double kSlowMotion = 0.2;    ///< of a joint's rms speed: n is seen where the slower motion lets it pass
constexpr double kApart = 3.0;         ///< steps of n between two starts

/// What is left of the effort at one joint, where and how fast it moved.
struct Left {
  std::vector<double> q, v, rest;  ///< rad (m), rad/s (m/s), channel units
};

Left left_of(const CurrentModel& current, const FitContext& context, int joint) {
  const std::vector<int> train = context.experiment.with_role(Role::train);
  const Problem problem = problem_of(current, context);
  Left out;
  for (const ResidualBlock& block : problem.layout(train)) {
    const std::size_t c = block.channel;
    const Channel& channel = context.experiment.channels[c];
    if (channel.joint != joint || channel.kind != ChannelKind::effort) continue;
    const Segment& segment = context.experiment.segments[block.segment];
    Eigen::Index row = block.first;
    for (std::size_t k = 0; k < segment.compared.size(); ++k) {
      if (!std::isfinite(segment.measured[c][k])) continue;
      out.q.push_back(segment.motion->q[joint][segment.compared[k]]);
      out.v.push_back(segment.motion->v[joint][segment.compared[k]]);
      out.rest.push_back(current.weights[c] * current.fit.residual(row++));
    }
  }
  return out;
}

/// The ripple of one n that takes most energy off the rest.
struct Ripple {
  double energy = 0.0, a = 0.0, b = 0.0, n = 0.0;
};

Ripple ripple_of(double ss, double sc, double cc, double rs, double rc, double n) {
  const double det = ss * cc - sc * sc;
  if (!(det > 1e-6 * ss * cc)) return {};
  const double a = (rs * cc - rc * sc) / det, b = (rc * ss - rs * sc) / det;
  return {a * rs + b * rc, a, b, n};
}

/// Of n = first, first + step, ...; what the filter takes off a ripple that passes quickly is taken off here, too.
std::vector<Ripple> spectrum(const Left& left, double first, double step, int count, double cutoff_hz) {
  const std::size_t samples = left.q.size();
  std::vector<std::complex<double>> turn(samples), at(samples);
  for (std::size_t k = 0; k < samples; ++k)
    turn[k] = std::polar(1.0, step * left.q[k]), at[k] = std::polar(1.0, first * left.q[k]);
  std::vector<Ripple> out;
  for (int i = 0; i < count; ++i) {
    const double n = first + step * i, passes = n / (2.0 * std::numbers::pi * cutoff_hz);
    double ss = 0.0, sc = 0.0, cc = 0.0, rs = 0.0, rc = 0.0;
    for (std::size_t k = 0; k < samples; ++k) {
      const double fast = passes * left.v[k], square = fast * fast;
      const double gain = 1.0 / (1.0 + square * square);  // second order, forwards and backwards
      const double s = gain * at[k].imag(), c = gain * at[k].real();
      ss += s * s, sc += s * c, cc += c * c, rs += left.rest[k] * s, rc += left.rest[k] * c;
      at[k] *= turn[k];
    }
    out.push_back(ripple_of(ss, sc, cc, rs, rc, n));
  }
  return out;
}

}  // namespace

std::vector<std::vector<double>> ripple_starts(const CurrentModel& current, const FitContext& context, int joint) {
  const auto* inverse = std::get_if<InverseDynamics>(&context.experiment.prediction);
  const double range = 2.0 * context.experiment.position_reach[joint], speed = context.experiment.speed_rms[joint];
  if (inverse == nullptr || !(range > 0.0) || !(speed > 0.0)) return {};
  const Left left = left_of(current, context, joint);
  if (left.q.empty()) return {};
  const double step = 1.0 / range, most = 2.0 * std::numbers::pi * inverse->cutoff_hz / (kSlowMotion * speed);
  const double first = 2.0 * std::numbers::pi / range;  // a whole period within the travel
  const int count = static_cast<int>(std::clamp((most - first) / step, 1.0, kMostNumbers));
  std::vector<Ripple> ripples = spectrum(left, first, step, count, inverse->cutoff_hz);
  std::stable_sort(ripples.begin(), ripples.end(),
                   [](const Ripple& x, const Ripple& y) { return x.energy > y.energy; });
  std::vector<std::vector<double>> out;
  for (const Ripple& r : ripples) {
    const bool near = std::any_of(out.begin(), out.end(), [&](const std::vector<double>& other) {
      return std::fabs(other[2] - r.n) < kApart * step;
    });
    if (!near && r.energy > 0.0) out.push_back({r.a, r.b, r.n});
    if (out.size() == kStarts) break;
  }
  return out;
}

}  // namespace lacuna
