// A rigid body's ten inertial parameters as one symmetric 4x4 matrix.
//
// P = [[S, h], [h^T, m]] with S = integral of r r^T dm (kg m^2), h = integral of r dm (kg m), m (kg), r from the
// frame's origin. A body of positive mass everywhere has a positive definite P, and every positive definite P is such a
// body's; a frame change r -> A r + t acts as P -> U P U^T, U = [[A, t], [0, 1]]. Source: P. M. Wensing, S. Kim, J.-J.
// Slotine, IEEE Robotics Autom. Lett. 3 (2018).
#pragma once

#include <Eigen/Core>

#include "scenarios/robot.h"

namespace lacuna {

inline Eigen::Matrix4d pseudo_inertia(const Inertial& body) {
  Eigen::Matrix4d out;
  out.topLeftCorner<3, 3>() = 0.5 * body.inertia.trace() * Eigen::Matrix3d::Identity() - body.inertia +
                              body.mass * body.com * body.com.transpose();
  out.topRightCorner<3, 1>() = body.mass * body.com;
  out.bottomLeftCorner<1, 3>() = body.mass * body.com.transpose();
  out(3, 3) = body.mass;
  return out;
}

inline Inertial from_pseudo_inertia(const Eigen::Matrix4d& pseudo) {
  Inertial out;
  out.mass = pseudo(3, 3);
  out.com = pseudo.topRightCorner<3, 1>() / out.mass;
  const Eigen::Matrix3d spread = pseudo.topLeftCorner<3, 3>() - out.mass * out.com * out.com.transpose();
  out.inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  return out;
}

}  // namespace lacuna
