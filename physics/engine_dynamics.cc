#include "physics/engine_dynamics.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace lacuna {

EngineDynamics::EngineDynamics(std::unique_ptr<Dynamics> dynamics)
    : dynamics_(std::move(dynamics)), armature_(Eigen::VectorXd::Zero(dynamics_->dof())) {}

void EngineDynamics::forward_dynamics(const double* q, const double* v, const double* tau, const double* free,
                                      double* a, double* imbalance) {
  const std::size_t n = dynamics_->dof();
  dynamics_->forward_dynamics({q, n}, {v, n}, {tau, n}, {a, n});
  const bool reflected = armature_.any();
  if (!reflected && std::all_of(free, free + n, [](double f) { return f != 0.0; })) {
    std::fill(imbalance, imbalance + n, 0.0);
    return;
  }
  // M a = tau - h holds for the free robot. With joints H held: M_FF a_F = (tau - h)_F, and the holders take up
  // (tau - h)_H - M_HF a_F.
  dynamics_->mass_matrix({q, n}, mass_);
  const Eigen::VectorXd net = mass_ * Eigen::Map<const Eigen::VectorXd>(a, dynamics_->dof());
  mass_.diagonal() += armature_;
  std::vector<Eigen::Index> moving;
  for (std::size_t i = 0; i < n; ++i) {
    if (free[i] != 0.0) moving.push_back(i);
  }
  Eigen::VectorXd reduced = Eigen::VectorXd::Zero(dynamics_->dof());
  if (!moving.empty()) {
    const Eigen::MatrixXd block = mass_(moving, moving);
    const Eigen::VectorXd solved = block.llt().solve(net(moving).eval());
    for (std::size_t k = 0; k < moving.size(); ++k) reduced(moving[k]) = solved(k);
  }
  const Eigen::VectorXd left = net - mass_ * reduced;
  for (std::size_t i = 0; i < n; ++i) {
    a[i] = reduced(i);
    imbalance[i] = left(i);
  }
}

void EngineDynamics::mass_matrix(const double* q, double* mass) {
  const std::size_t n = dynamics_->dof();
  dynamics_->mass_matrix({q, n}, mass_);
  mass_.diagonal() += armature_;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) mass[i * n + j] = mass_(i, j);
}

void EngineDynamics::inverse_dynamics(const double* q, const double* v, const double* a, double* tau) {
  const std::size_t n = dynamics_->dof();
  dynamics_->inverse_dynamics({q, n}, {v, n}, {a, n}, {tau, n});
  for (std::size_t i = 0; i < n; ++i) tau[i] += armature_(i) * a[i];
}

}  // namespace lacuna
