// A plant linearised along one simulated motion, from sample to sample.
//
// With x = (q, v, component states) and efforts held over the interval between two samples,
//   dx[k + 1] = A[k] dx[k] + B[k] dtau[k],
// A and B by differences of the simulation itself, interval by interval, so that whatever acts in the plant is in them.
// What any cause does to the motion follows to first order from the efforts that it adds along the motion, without a
// simulation of it: L. Ljung, System Identification, 2nd ed., 1999, sec. 4.3 (sampled linearised state equations).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "physics/measured_motion.h"

namespace lacuna {

struct LinearMotion {
  int dof = 0;
  std::vector<Eigen::MatrixXd> A, B;  ///< [interval]: states x states, states x joints; units rad (m), s, N m (N)
  /// The motion itself in the middle of every interval: positions and speeds the means of both ends', accelerations
  /// what leads from one speed to the other. NaN from where it diverges.
  std::shared_ptr<const MeasuredMotion> between;

  std::size_t intervals() const { return A.size(); }
  bool is_finite() const;

  /// Changes of all joints' positions (rows [0, dof)) and speeds (rows [dof, 2 dof)) at every sample, rad (m) and
  /// rad/s (m/s), under additional efforts [joint][interval], N m (N).
  Eigen::MatrixXd response(const Eigen::MatrixXd& efforts) const;
  /// The same, one for each row of efforts at one joint alone: [row][interval].
  std::vector<Eigen::MatrixXd> responses_at(int joint, const Eigen::MatrixXd& efforts) const;
};

}  // namespace lacuna
