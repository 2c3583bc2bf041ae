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
    auto whole = next.head(next.size());  // has its size: GCC 12 warns of the vector's being freed in between
    whole.noalias() = A[k] * x;
    whole.noalias() += B[k] * efforts.col(column);
    x.swap(next);
    out.col(column + 1) = x.head(rows);
  }
  return out;
}

std::vector<Eigen::MatrixXd> LinearMotion::responses_at(int joint, const Eigen::MatrixXd& efforts) const {
  const Eigen::Index rows = 2 * dof, many = efforts.rows();
  std::vector<Eigen::MatrixXd> out(many, Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(intervals()) + 1));
  if (intervals() == 0) return out;
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(A.front().rows(), many), next(x.rows(), many);
  for (std::size_t k = 0; k < intervals(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    next.noalias() = A[k] * x;
    next.noalias() += B[k].col(joint) * efforts.col(column).transpose();
    x.swap(next);
    for (Eigen::Index i = 0; i < many; ++i) out[i].col(column + 1) = x.col(i).head(rows);
  }
  return out;
}

}  // namespace lacuna
