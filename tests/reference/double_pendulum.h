// Two bars in a vertical plane in closed form. Bar i: mass m_i, centre of mass c_i below its joint, inertia I_i about
// it; the second joint hangs L below the first. q_1 from hanging, q_2 relative to the first bar.
//
// With absolute angles p_1 = q_1, p_2 = q_1 + q_2 and d = p_1 - p_2:
//   kinetic    1/2 (I_1 + m_1 c_1^2 + m_2 L^2) p_1'^2 + 1/2 (I_2 + m_2 c_2^2) p_2'^2 + m_2 L c_2 cos(d) p_1' p_2'
//   potential  -(m_1 c_1 + m_2 L) g cos p_1 - m_2 c_2 g cos p_2
// and Lagrange's equations, with work tau_1 dq_1 + tau_2 dq_2 = (tau_1 - tau_2) dp_1 + tau_2 dp_2:
//   A p_1'' + C p_2'' = tau_1 - tau_2 - m_2 L c_2 sin(d) p_2'^2 - (m_1 c_1 + m_2 L) g sin p_1
//   C p_1'' + B p_2'' = tau_2         + m_2 L c_2 sin(d) p_1'^2 - m_2 c_2 g sin p_2
#pragma once

#include <cmath>

#include "tests/reference/robots.h"

namespace lacuna::test {

struct DoublePendulum {
  double mass[2] = {2.0, 1.3};
  double com[2] = {0.35, 0.25};
  double inertia[2] = {0.09, 0.04};
  double length = 0.7;
  double gravity = 9.81;

  Eigen::Vector2d acceleration(const Eigen::Vector2d& q, const Eigen::Vector2d& v, const Eigen::Vector2d& tau) const {
    const double p1 = q[0], p2 = q[0] + q[1], w1 = v[0], w2 = v[0] + v[1];
    const double coupling = mass[1] * length * com[1];
    const double a = inertia[0] + mass[0] * com[0] * com[0] + mass[1] * length * length;
    const double b = inertia[1] + mass[1] * com[1] * com[1];
    const double c = coupling * std::cos(p1 - p2);
    const double s = coupling * std::sin(p1 - p2);
    const double f1 = tau[0] - tau[1] - s * w2 * w2 - (mass[0] * com[0] + mass[1] * length) * gravity * std::sin(p1);
    const double f2 = tau[1] + s * w1 * w1 - mass[1] * com[1] * gravity * std::sin(p2);
    const double determinant = a * b - c * c;
    const double a1 = (b * f1 - c * f2) / determinant;
    const double a2 = (a * f2 - c * f1) / determinant;
    return {a1, a2 - a1};
  }

  double energy(const Eigen::Vector2d& q, const Eigen::Vector2d& v) const {
    const double p1 = q[0], p2 = q[0] + q[1], w1 = v[0], w2 = v[0] + v[1];
    return 0.5 * (inertia[0] + mass[0] * com[0] * com[0] + mass[1] * length * length) * w1 * w1 +
           0.5 * (inertia[1] + mass[1] * com[1] * com[1]) * w2 * w2 +
           mass[1] * length * com[1] * std::cos(p1 - p2) * w1 * w2 -
           (mass[0] * com[0] + mass[1] * length) * gravity * std::cos(p1) - mass[1] * com[1] * gravity * std::cos(p2);
  }

  /// Swings about y, hangs along -z.
  std::shared_ptr<const Robot> robot() const {
    BodySpec upper, lower;
    upper.axis = lower.axis = Eigen::Vector3d::UnitY();
    upper.inertial = bar(0);
    lower.inertial = bar(1);
    lower.parent = 0;
    lower.origin = at(0, 0, -length);
    return make_robot("double_pendulum", {upper, lower});
  }

 private:
  Inertial bar(int i) const {
    return {mass[i], {0, 0, -com[i]}, Eigen::Vector3d(inertia[i], inertia[i], 0.1 * inertia[i]).asDiagonal()};
  }
};

}  // namespace lacuna::test
