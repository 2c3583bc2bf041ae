#include "diff/joint_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ga/optimizer.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kJointShare = 1e-5;  ///< of the cost: steps that gain less end the descent,
constexpr double kJointNats = 0.02;   ///< or less than this, in units of the log-likelihood
constexpr double kFirstJointDamping = 1e-3;
constexpr double kLeastJointDamping = 1e-9, kMostJointDamping = 1e6;

/// One side's train recordings at its point.
class SideAt {
 public:
  SideAt(const Side& side, const std::vector<double>& point)
      : side_(side), train_(side.experiment.with_role(Role::train)), problem_(problem_of(side.model, side.context())) {
    move(point);
  }
  void move(const std::vector<double>& point) { point_ = point, residual_ = problem_.residual(point, train_); }
  double energy(const std::vector<double>& point) {
    const Eigen::VectorXd r = problem_.residual(point, train_);
    return r.allFinite() ? r.squaredNorm() : HUGE_VAL;
  }
  double energy() const { return residual_.allFinite() ? residual_.squaredNorm() : HUGE_VAL; }
  /// Information and minus half the gradient of the energy, in units of the priors.
  Quadratic slopes() {
    Eigen::MatrixXd J = problem_.jacobian(point_, residual_, train_);
    for (std::size_t i = 0; i < point_.size(); ++i) J.col(i) *= side_.axes()[i].prior;
    return {J.transpose() * J, -J.transpose() * residual_};
  }

 private:
  const Side& side_;
  std::vector<int> train_;
  Problem problem_;
  std::vector<double> point_;
  Eigen::VectorXd residual_;
};

class Descent {
 public:
  Descent(const Side& a, const Side& b, const ChangeGroups& groups, const ChangedSet& changed, JointFit start)
      : columns_(a.axes().size(), groups, changed), side_(a), now_(std::move(start)) {
    settle(a, now_.a, b, now_.b);
    a_.emplace(a, now_.a), b_.emplace(b, now_.b);
    now_.cost = a_->energy() + b_->energy() + prior(now_);
  }

  bool simulated() const { return std::isfinite(now_.cost); }
  const JointFit& now() const { return now_; }

  /// Whether another step was found that is worth going on from.
  bool step() {
    const auto n = static_cast<Eigen::Index>(now_.a.size());
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
    const Quadratic sa = a_->slopes(), sb = b_->slopes();
    const Eigen::MatrixXd K = columns_.joined(sa.information, sb.information, ones);
    // The prior's slope: its matrix times the present point.
    const Eigen::MatrixXd nothing = Eigen::MatrixXd::Zero(n, n), P = columns_.joined(nothing, nothing, ones);
    const Eigen::VectorXd down = columns_.joined(sa.linear, sb.linear) - P * stacked(now_);
    for (; damping_ < kMostJointDamping; damping_ *= 10.0) {
      JointFit next = moved(bounded_step(K, down));
      next.cost = a_->energy(next.a);
      if (std::isfinite(next.cost)) next.cost += b_->energy(next.b) + prior(next);
      if (!(next.cost < now_.cost)) continue;
      const double gain = now_.cost - next.cost;
      next.iterations = now_.iterations + 1;
      now_ = std::move(next);
      a_->move(now_.a), b_->move(now_.b);
      damping_ = std::max(kLeastJointDamping, 0.1 * damping_);
      return gain > std::max(kJointShare * now_.cost, 2.0 * kJointNats);
    }
    return false;
  }

 private:
  /// Common numbers made equal; those pinned on either side stand there and stay.
  void settle(const Side& a, std::vector<double>& xa, const Side& b, std::vector<double>& xb) {
    held_.assign(columns_.size(), 0);
    for (std::size_t i = 0; i < xa.size(); ++i)
      if (!columns_.apart(i)) xb[i] = xa[i];
    for (const auto& [i, value] : a.pins) {
      xa[i] = value, held_[i] = 1;
      if (!columns_.apart(i)) xb[i] = value;
    }
    for (const auto& [i, value] : b.pins) {
      xb[i] = value, held_[columns_.of_b(i)] = 1;
      if (!columns_.apart(i)) xa[i] = value;
    }
  }

  Eigen::VectorXd stacked(const JointFit& at) const {
    Eigen::VectorXd out(columns_.size());
    const Eigen::VectorXd ya = in_priors(side_, at.a), yb = in_priors(side_, at.b);
    for (Eigen::Index i = 0; i < ya.size(); ++i) out(columns_.of_b(i)) = yb(i);
    out.head(ya.size()) = ya;
    return out;
  }

  double prior(const JointFit& at) const {
    const Eigen::VectorXd ya = in_priors(side_, at.a), yb = in_priors(side_, at.b);
    return ya.squaredNorm() + (yb - ya).squaredNorm();
  }

  JointFit moved(const Eigen::VectorXd& step) const {
    JointFit out = now_;
    for (std::size_t i = 0; i < out.a.size(); ++i) {
      const Axis& axis = side_.axes()[i];
      const auto column = static_cast<Eigen::Index>(i);
      out.a[i] = std::clamp(out.a[i] + axis.prior * step(column), axis.lower, axis.upper);
      out.b[i] = std::clamp(out.b[i] + axis.prior * step(columns_.of_b(column)), axis.lower, axis.upper);
    }
    return out;
  }

  /// A number at a bound that the step would take beyond it stays, and the others step without it.
  Eigen::VectorXd bounded_step(const Eigen::MatrixXd& K, const Eigen::VectorXd& down) const {
    std::vector<char> held = held_;
    for (;;) {
      Eigen::MatrixXd damped = K;
      damped.diagonal() *= 1.0 + damping_;
      Eigen::VectorXd slope = down;
      for (Eigen::Index c = 0; c < K.rows(); ++c) {
        if (held[c] == 0) continue;
        damped.row(c).setZero(), damped.col(c).setZero();
        damped(c, c) = 1.0, slope(c) = 0.0;
      }
      const Eigen::VectorXd out = damped.ldlt().solve(slope);
      if (!hold_at_bounds(out, held)) return out;
    }
  }

  bool hold_at_bounds(const Eigen::VectorXd& step, std::vector<char>& held) const {
    bool more = false;
    const auto look = [&](std::size_t i, Eigen::Index column, double x) {
      const Axis& axis = side_.axes()[i];
      const bool out = (x <= axis.lower && step(column) < 0.0) || (x >= axis.upper && step(column) > 0.0);
      if (out) held[column] = 1, more = true;
    };
    for (std::size_t i = 0; i < now_.a.size(); ++i) {
      look(i, i, now_.a[i]);
      look(i, columns_.of_b(i), now_.b[i]);
    }
    return more;
  }

  JointColumns columns_;
  const Side& side_;  ///< whose axes both sides have
  JointFit now_;
  std::optional<SideAt> a_, b_;
  std::vector<char> held_;
  double damping_ = kFirstJointDamping;
};

}  // namespace

ChangeGroups groups_of(const std::vector<Changeable>& changeables) {
  ChangeGroups out;
  for (const Changeable& c : changeables) {
    out.emplace_back();
    for (const std::size_t a : c.axes) out.back().push_back(a);
  }
  return out;
}

JointFit fit_jointly(const Side& a, const Side& b, const ChangeGroups& groups, const ChangedSet& changed,
                     JointFit start, const std::atomic<bool>* stop, int iterations) {
  start.iterations = 0;
  Descent descent(a, b, groups, changed, std::move(start));
  if (!descent.simulated()) throw WorkError("the two sets cannot be simulated from where their fits ended");
  for (int k = 0; k < iterations && descent.step(); ++k)
    if (stop != nullptr && *stop) throw Interrupted();
  return descent.now();
}

}  // namespace lacuna
