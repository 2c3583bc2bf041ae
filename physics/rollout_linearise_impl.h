// Definitions of rollout.h: the plant linearised along its own motion. Included by it only.
#pragma once

#include <algorithm>
#include <cmath>

namespace lacuna {

/// Where the motion of all lanes stands at every sample.
template <class T, class Dyn>
std::vector<typename Rollout<T, Dyn>::Waypoint> Rollout<T, Dyn>::waypoints(double max_step) {
  start(max_step);
  std::vector<Waypoint> out{{x_, memory_, direction_}};
  for (std::size_t k = 0; k + 1 < count(); ++k) {
    advance(k, max_step);
    out.push_back({x_, memory_, direction_});
  }
  return out;
}

template <class T, class Dyn>
std::shared_ptr<const MeasuredMotion> Rollout<T, Dyn>::between(const std::vector<Waypoint>& way) const {
  auto out = std::make_shared<MeasuredMotion>();
  out->q.resize(n_), out->v.resize(n_), out->a.resize(n_), out->direction.resize(n_);
  out->v_error.assign(n_, 0.0);
  for (std::size_t k = 0; k + 1 < way.size(); ++k) {
    const double begin = lane(time(k), 0), end = lane(time(k + 1), 0);
    out->time.push_back(0.5 * (begin + end));
    for (std::size_t j = 0; j < n_; ++j) {
      const auto at = [&](std::size_t sample, std::size_t i) { return lane(way[sample].x[i], 0); };
      const double v0 = at(k, n_ + j), v1 = at(k + 1, n_ + j), v = 0.5 * (v0 + v1);
      out->q[j].push_back(0.5 * (at(k, j) + at(k + 1, j)));
      out->v[j].push_back(v);
      out->a[j].push_back((v1 - v0) / (end - begin));
      out->direction[j].push_back(sign(v));
    }
  }
  out->rate =
      out->time.size() > 1 ? static_cast<double>(out->time.size() - 1) / (out->time.back() - out->time.front()) : 1.0;
  return out;
}

template <class T, class Dyn>
LinearMotion Rollout<T, Dyn>::linearise(const Segment& segment, double max_step,
                                        const std::vector<double>& effort_sizes) {
  segments_.fill(&segment);
  const std::vector<Waypoint> way = waypoints(max_step);
  std::vector<double> steps;  // of every state, then of every effort
  for (std::size_t i = 0; i < size_; ++i) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Waypoint& w : way) low = std::min(low, lane(w.x[i], 0)), high = std::max(high, lane(w.x[i], 0));
    const double range = std::max(high - low, 1e-3 * std::max(std::fabs(low), std::fabs(high)));
    steps.push_back(kDifference * (range > 0.0 ? range : 1.0));
  }
  for (const double size : effort_sizes) steps.push_back(kDifference * (size > 0.0 ? size : 1.0));

  LinearMotion out{static_cast<int>(n_), {}, {}, between(way)};
  const auto states = static_cast<Eigen::Index>(size_);
  out.A.assign(way.size() - 1, Eigen::MatrixXd(states, states));
  out.B.assign(way.size() - 1, Eigen::MatrixXd(states, n_));
  const std::size_t lanes = kLanes<T>;
  for (std::size_t first = 0; first < steps.size(); first += lanes) {
    start(max_step);
    const std::size_t last = std::min(first + lanes, steps.size());
    for (std::size_t i = std::max(first, size_); i < last; ++i)
      set_lane(probe_[i - size_], static_cast<int>(i - first), steps[i]);
    for (std::size_t k = 0; k + 1 < way.size(); ++k) {
      x_ = way[k].x, memory_ = way[k].memory, direction_ = way[k].direction;
      for (std::size_t i = first; i < std::min(last, size_); ++i) {
        const int at = static_cast<int>(i - first);
        set_lane(x_[i], at, lane(x_[i], at) + steps[i]);
      }
      advance(k, max_step);
      for (std::size_t i = first; i < last; ++i) {
        Eigen::MatrixXd& to = i < size_ ? out.A[k] : out.B[k];
        const auto column = static_cast<Eigen::Index>(i < size_ ? i : i - size_);
        for (std::size_t row = 0; row < size_; ++row)
          to(row, column) = (lane(x_[row], static_cast<int>(i - first)) - lane(way[k + 1].x[row], 0)) / steps[i];
      }
    }
    std::fill(probe_.begin(), probe_.end(), T(0.0));
  }
  return out;
}

}  // namespace lacuna
