// The pendulum in closed form: mass m (kg), centre of mass l (m) below a horizontal axis, inertia I (kg m^2) about an
// axis through the centre of mass. q (rad) is measured from hanging; g (m/s^2) pulls down.
//
// Lagrangian  L = 1/2 (I + m l^2) q'^2 + m g l cos q,  so  (I + m l^2) q'' = tau - m g l sin q.
//
// Period from rest at amplitude A: energy gives q'^2 = 2 w^2 (cos q - cos A) with w^2 = m g l / (I + m l^2); the
// substitution sin(q/2) = sin(A/2) sin(phi) turns the quarter period into Legendre's integral,
//   T = 4/w K(k),  k = sin(A/2);  for A -> 0, K -> pi/2.
#pragma once

#include <boost/math/special_functions/ellint_1.hpp>
#include <cmath>
#include <numbers>

#include "tests/reference/robots.h"

namespace lacuna::test {

struct Pendulum {
  double mass = 1.7;
  double length = 0.6;    ///< from the axis to the centre of mass
  double inertia = 0.05;  ///< about the centre of mass
  double gravity = 9.81;

  double about_axis() const { return inertia + mass * length * length; }
  double acceleration(double q, double tau) const {
    return (tau - mass * gravity * length * std::sin(q)) / about_axis();
  }
  double angular_frequency() const { return std::sqrt(mass * gravity * length / about_axis()); }
  double small_angle_period() const { return 2.0 * std::numbers::pi / angular_frequency(); }
  double period(double amplitude) const {
    return 4.0 / angular_frequency() * boost::math::ellint_1(std::sin(0.5 * amplitude));
  }

  /// Swings about y, hangs along -z.
  std::shared_ptr<const Robot> robot() const {
    BodySpec body;
    body.axis = Eigen::Vector3d::UnitY();
    body.inertial = {mass, {0, 0, -length}, Eigen::Vector3d(inertia, inertia, 0.5 * inertia).asDiagonal()};
    return make_robot("pendulum", {body});
  }
};

}  // namespace lacuna::test
