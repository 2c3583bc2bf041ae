// Motion through an engine's forward dynamics, integrated by the tests themselves, and its momentum read off body
// poses.
#pragma once

#include <vector>

#include "backends/engine.h"

namespace lacuna::test {

/// Kutta's fourth-order method with tau held.
inline void rk4_step(Dynamics& dynamics, std::vector<double>& q, std::vector<double>& v, const std::vector<double>& tau,
                     double h) {
  const std::size_t n = q.size();
  const double nodes[4] = {0.0, 0.5, 0.5, 1.0}, weights[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  std::vector<double> a(n, 0.0), stage_v = v, stage_q = q, end_q = q, end_v = v;
  for (int k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      stage_q[i] = q[i] + h * nodes[k] * (k == 0 ? 0.0 : stage_v[i]);
      // stage_v still holds the previous stage's rate above; now advance it.
      stage_v[i] = v[i] + h * nodes[k] * a[i];
    }
    dynamics.forward_dynamics(stage_q, stage_v, tau, a);
    for (std::size_t i = 0; i < n; ++i) {
      end_q[i] += h * weights[k] * stage_v[i];
      end_v[i] += h * weights[k] * a[i];
    }
  }
  q = end_q;
  v = end_v;
}

inline void rk4_run(Dynamics& dynamics, std::vector<double>& q, std::vector<double>& v, const std::vector<double>& tau,
                    double seconds, int steps) {
  for (int k = 0; k < steps; ++k) rk4_step(dynamics, q, v, tau, seconds / steps);
}

struct Momentum {
  std::vector<Eigen::Vector3d> linear;                ///< kg m/s, per body
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< kg m^2/s, of all bodies about the world origin
};

/// From poses alone: velocities are central differences of poses along v, over 1e-5 s (truncation about 1e-10 of size,
/// rounding about 1e-11). Independent of the engine's mass matrix and energy.
inline Momentum momentum(Dynamics& dynamics, const std::vector<double>& q, const std::vector<double>& v) {
  const double half = 1e-5;
  std::vector<double> ahead = q, behind = q;
  for (std::size_t i = 0; i < q.size(); ++i) {
    ahead[i] += half * v[i];
    behind[i] -= half * v[i];
  }
  std::vector<Eigen::Isometry3d> before, now, after;
  dynamics.body_poses(behind, before);
  dynamics.body_poses(q, now);
  dynamics.body_poses(ahead, after);
  Momentum sum;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Inertial body = dynamics.robot().body_inertial(static_cast<int>(i));
    const Eigen::Vector3d rate = (after[i] * body.com - before[i] * body.com) / (2.0 * half);
    const Eigen::Matrix3d spin = (after[i].linear() - before[i].linear()) / (2.0 * half) * now[i].linear().transpose();
    const Eigen::Vector3d omega =
        0.5 * Eigen::Vector3d(spin(2, 1) - spin(1, 2), spin(0, 2) - spin(2, 0), spin(1, 0) - spin(0, 1));
    sum.linear.emplace_back(body.mass * rate);
    sum.angular += (now[i] * body.com).cross(body.mass * rate) +
                   now[i].linear() * body.inertia * now[i].linear().transpose() * omega;
  }
  return sum;
}

}  // namespace lacuna::test
