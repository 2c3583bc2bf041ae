// For engines that cannot hold a body without inertia about some axis (a point mass, a thin rod).
#pragma once

#include <Eigen/Eigenvalues>

#include "scenarios/robot.h"

namespace lacuna {

/// The inertia of `inertial` about its centre of mass (kg m^2), its principal moments at least `share` of what the body
/// has about its own frame; of a mass at the frame's origin, which has nothing there either, `share` times 1 m^2 a kg.
inline Eigen::Matrix3d with_least_inertia(const Inertial& inertial, double share) {
  const double about_frame = 0.5 * inertial.inertia.trace() + inertial.mass * inertial.com.squaredNorm();
  const double least = share * (about_frame > 0 ? about_frame : inertial.mass);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertial.inertia);
  if (principal.eigenvalues().minCoeff() >= least) return inertial.inertia;
  const Eigen::Vector3d raised = principal.eigenvalues().cwiseMax(least);
  return principal.eigenvectors() * raised.asDiagonal() * principal.eigenvectors().transpose();
}

}  // namespace lacuna
