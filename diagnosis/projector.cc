#include "diagnosis/projector.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

constexpr double kDamping = 1e-6;  // of own columns that are nearly alike, relative to the normal matrix' diagonal

}  // namespace

Projector::Projector(const Eigen::MatrixXd& jacobian) {
  Eigen::MatrixXd scaled = jacobian;
  for (Eigen::Index a = 0; a < scaled.cols(); ++a) scaled.col(a) /= std::max(scaled.col(a).norm(), 1e-300);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(jacobian.rows(), qr.rank());
}

Eigen::VectorXd Projector::rest(const Eigen::VectorXd& change) const {
  return change - basis_ * (basis_.transpose() * change);
}

double Projector::left_over(const Eigen::VectorXd& residual, const Eigen::MatrixXd& own,
                            const Eigen::MatrixX2d& room) const {
  const Eigen::VectorXd r = rest(residual);
  const Eigen::MatrixXd G = own - basis_ * (basis_.transpose() * own);
  Eigen::MatrixXd normal = G.transpose() * G;
  normal.diagonal() *= 1.0 + kDamping;
  normal.diagonal().array() += 1e-300;
  const Eigen::VectorXd step =
      normal.ldlt().solve(-(G.transpose() * r).eval()).cwiseMax(room.col(0)).cwiseMin(room.col(1));
  if (!step.allFinite()) return HUGE_VAL;
  return std::min(r.squaredNorm(), (r + G * step).squaredNorm());
}

}  // namespace lacuna
