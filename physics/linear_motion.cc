#include "physics/linear_motion.h"

#include <algorithm>

namespace lacuna {

bool LinearMotion::is_finite() const {
  const auto finite = [](const Eigen::MatrixXd& m) { return m.allFinite(); };
  return std::all_of(A.begin(), A.end(), finite) && std::all_of(B.begin(), B.end(), finite);
}

Eigen::MatrixXd LinearMotion::response(const Eigen::MatrixXd& efforts) const {
  const Eigen::Index rows = 2 * dof;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(intervals()) + 1);
  if (intervals() == 0) return out;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(A.front().rows()), next(x.size());
  for (std::size_t k = 0; k < intervals(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    next.noalias() = A[k] * x;
    next.noalias() += B[k] * efforts.col(column);
    x.swap(next);
    out.col(column + 1) = x.head(rows);
  }
  return out;
}

}  // namespace lacuna
