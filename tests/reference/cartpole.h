// A cart on a horizontal rail with a hanging pole, in closed form. Cart M; pole m, centre of mass l below the hinge,
// inertia I about it. x along the rail; q from hanging, turning the pole's tip towards -x.
//
// The centre of mass lies at (x - l sin q, -l cos q), so
//   L = 1/2 (M + m) x'^2 - m l cos(q) x' q' + 1/2 (I + m l^2) q'^2 + m g l cos q
//   (M + m) x'' - m l cos(q) q'' = force - m l sin(q) q'^2
//   -m l cos(q) x'' + (I + m l^2) q'' = torque - m g l sin q
#pragma once

#include <cmath>

#include "tests/reference/robots.h"

namespace lacuna::test {

struct Cartpole {
  double cart = 3.0;
  double pole = 0.8;
  double length = 0.5;
  double inertia = 0.03;
  double gravity = 9.81;

  /// q = (x, q), v = (x', q'), effort = (force, torque).
  Eigen::Vector2d acceleration(const Eigen::Vector2d& q, const Eigen::Vector2d& v,
                               const Eigen::Vector2d& effort) const {
    const double a = cart + pole;
    const double b = inertia + pole * length * length;
    const double c = -pole * length * std::cos(q[1]);
    const double f1 = effort[0] - pole * length * std::sin(q[1]) * v[1] * v[1];
    const double f2 = effort[1] - pole * gravity * length * std::sin(q[1]);
    const double determinant = a * b - c * c;
    return {(b * f1 - c * f2) / determinant, (a * f2 - c * f1) / determinant};
  }

  double energy(const Eigen::Vector2d& q, const Eigen::Vector2d& v) const {
    return 0.5 * (cart + pole) * v[0] * v[0] - pole * length * std::cos(q[1]) * v[0] * v[1] +
           0.5 * (inertia + pole * length * length) * v[1] * v[1] - pole * gravity * length * std::cos(q[1]);
  }

  /// Rail along x, hinge about y.
  std::shared_ptr<const Robot> robot() const {
    BodySpec base, bar;
    base.type = JointType::prismatic;
    base.axis = Eigen::Vector3d::UnitX();
    base.inertial = {cart, Eigen::Vector3d::Zero(), 0.02 * Eigen::Matrix3d::Identity()};
    bar.parent = 0;
    bar.type = JointType::continuous;
    bar.axis = Eigen::Vector3d::UnitY();
    bar.inertial = {pole, {0, 0, -length}, Eigen::Vector3d(inertia, inertia, 0.1 * inertia).asDiagonal()};
    return make_robot("cartpole", {base, bar});
  }
};

}  // namespace lacuna::test
