// What fitted parameters can take up of a residual, to first order, projected off.
#pragma once

#include <Eigen/Core>

namespace lacuna {

class Projector {
 public:
  /// Columns: sensitivities of the whitened residual to the fitted parameters, in any unit.
  explicit Projector(const Eigen::MatrixXd& jacobian);

  /// What the fitted parameters leave of a residual or of a change of it.
  Eigen::VectorXd rest(const Eigen::VectorXd& change) const;

  /// Orthonormal columns that span what the parameters can do.
  const Eigen::MatrixXd& basis() const { return basis_; }

  /// Energy of `residual` after the best step of the fitted parameters and of `own` ones (columns: sensitivities)
  /// within `room` (lower and upper, one row a column of `own`); infinite where there is no such step.
  double left_over(const Eigen::VectorXd& residual, const Eigen::MatrixXd& own, const Eigen::MatrixX2d& room) const;

 private:
  Eigen::MatrixXd basis_;  ///< orthonormal columns
};

}  // namespace lacuna
