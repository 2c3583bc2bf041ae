#include "backends/engine.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "scenarios/error.h"

namespace lacuna {
namespace {

void check_size(const char* what, std::size_t found, int expected) {
  if (found == static_cast<std::size_t>(expected)) return;
  throw std::invalid_argument("Dynamics: " + std::string(what) + " has " + std::to_string(found) +
                              " numbers, expected " + std::to_string(expected));
}

}  // namespace

void Dynamics::set_inertial(int body, const Inertial& inertial) {
  if (body < 0 || body >= dof()) {
    throw std::invalid_argument("Dynamics: body " + std::to_string(body) + ", expected 0 to " +
                                std::to_string(dof() - 1));
  }
  if (!(inertial.mass > 0) || !std::isfinite(inertial.mass) || !inertial.com.allFinite() ||
      !inertial.inertia.allFinite()) {
    throw std::invalid_argument("Dynamics: mass " + std::to_string(inertial.mass) + " of body " + std::to_string(body) +
                                ", expected a mass > 0 and finite properties");
  }
  do_set_inertial(body, inertial);
}

void Dynamics::set_gravity(const Eigen::Vector3d& gravity) {
  if (!gravity.allFinite()) throw std::invalid_argument("Dynamics: gravity is not finite");
  do_set_gravity(gravity);
}

void Dynamics::forward_dynamics(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
                                std::span<double> a) {
  check_size("q", q.size(), dof());
  check_size("v", v.size(), dof());
  check_size("tau", tau.size(), dof());
  check_size("a", a.size(), dof());
  do_forward_dynamics(q.data(), v.data(), tau.data(), a.data());
}

void Dynamics::inverse_dynamics(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                                std::span<double> tau) {
  check_size("q", q.size(), dof());
  check_size("v", v.size(), dof());
  check_size("a", a.size(), dof());
  check_size("tau", tau.size(), dof());
  do_inverse_dynamics(q.data(), v.data(), a.data(), tau.data());
}

void Dynamics::mass_matrix(std::span<const double> q, Eigen::MatrixXd& mass) {
  check_size("q", q.size(), dof());
  mass.resize(dof(), dof());
  do_mass_matrix(q.data(), mass);
}

void Dynamics::body_poses(std::span<const double> q, std::vector<Eigen::Isometry3d>& poses) {
  check_size("q", q.size(), dof());
  poses.resize(dof());
  do_body_poses(q.data(), poses);
}

Energy Dynamics::energy(std::span<const double> q, std::span<const double> v) {
  check_size("q", q.size(), dof());
  check_size("v", v.size(), dof());
  return do_energy(q.data(), v.data());
}

void Dynamics::native_step(const std::string& integrator, std::span<double> q, std::span<double> v,
                           std::span<const double> tau, double step) {
  check_size("q", q.size(), dof());
  check_size("v", v.size(), dof());
  check_size("tau", tau.size(), dof());
  if (!(step > 0) || !std::isfinite(step)) {
    throw std::invalid_argument("Dynamics: step " + std::to_string(step) + " s, expected a number > 0");
  }
  do_native_step(integrator, q.data(), v.data(), tau.data(), step);
}

void Dynamics::set_own_losses(std::span<const JointLoss> losses) {
  if (!losses.empty()) check_size("losses", losses.size(), dof());
  for (const JointLoss& loss : losses) {
    const double sum = loss.damping + loss.friction;
    if (!(loss.damping >= 0.0) || !(loss.friction >= 0.0) || !std::isfinite(sum))
      throw std::invalid_argument("Dynamics: a loss of " + std::to_string(sum) + ", expected finite numbers from 0");
  }
  do_set_own_losses(losses);
}

void Dynamics::do_set_own_losses(std::span<const JointLoss>) {
  throw WorkError("this engine has no losses of its own in its steps");
}

std::optional<JointGap> Dynamics::native_joint_gap(std::span<const double> q, std::span<const double> v, double step,
                                                   int steps, double correction) {
  check_size("q", q.size(), dof());
  check_size("v", v.size(), dof());
  if (!(step > 0) || !std::isfinite(step) || steps < 0 || !(correction >= 0.0 && correction <= 1.0)) {
    throw std::invalid_argument("Dynamics: " + std::to_string(steps) + " steps of " + std::to_string(step) +
                                " s with a correction of " + std::to_string(correction) +
                                ", expected a step > 0 and a correction from 0 to 1");
  }
  return do_native_joint_gap(q.data(), v.data(), step, steps, correction);
}

void Dynamics::do_mass_matrix(const double* q, Eigen::MatrixXd& mass) {
  const Eigen::Index n = dof();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd tau = rest, fall(n), a(n);
  do_forward_dynamics(q, rest.data(), rest.data(), fall.data());
  // A unit effort at joint j adds column j of the inverse to the fall.
  Eigen::MatrixXd inverse(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    tau.setZero();
    tau[j] = 1.0;
    do_forward_dynamics(q, rest.data(), tau.data(), a.data());
    inverse.col(j) = a - fall;
  }
  const Eigen::MatrixXd symmetric = 0.5 * (inverse + inverse.transpose());
  mass = symmetric.partialPivLu().inverse();
  mass = (0.5 * (mass + mass.transpose())).eval();
}

void Dynamics::do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) {
  const Eigen::Index n = dof();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd drift(n);
  do_forward_dynamics(q, v, none.data(), drift.data());
  Eigen::MatrixXd mass(n, n);
  do_mass_matrix(q, mass);
  Eigen::Map<Eigen::VectorXd>(tau, n) = mass * (Eigen::Map<const Eigen::VectorXd>(a, n) - drift);
}

}  // namespace lacuna
