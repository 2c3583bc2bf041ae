#include <stdexcept>

#include "backends/featherstone/forward_kernel.h"
#include "backends/featherstone/tree.h"
#include "backends/registry.h"

namespace lacuna {
namespace {

/// Asked here and not there: that file may hold instructions which this CPU lacks.
std::unique_ptr<ForwardKernel> fused_kernel([[maybe_unused]] const Robot& robot) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return make_fused_kernel(robot);
#endif
  return nullptr;
}

class FeatherstoneDynamics final : public Dynamics {
 public:
  FeatherstoneDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity)
      : Dynamics(robot),
        tree_(*robot),
        free_(robot->dof(), 1.0),
        imbalance_(free_.size()),
        fused_(fused_kernel(*robot)) {
    do_set_gravity(gravity);
    for (int i = 0; i < robot->dof(); ++i) masses_.push_back(robot->body_inertial(i));
  }

  std::unique_ptr<Dynamics> clone() const override { return std::make_unique<FeatherstoneDynamics>(*this); }
  FeatherstoneDynamics(const FeatherstoneDynamics& other)
      : Dynamics(other),
        tree_(other.tree_),
        masses_(other.masses_),
        free_(other.free_),
        imbalance_(other.imbalance_),
        gravity_(other.gravity_),
        fused_(other.fused_ ? other.fused_->clone() : nullptr) {}

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    tree_.set_inertial(body, 0, inertial);
    if (fused_) fused_->set_inertial(body, inertial);
    masses_[body] = inertial;
  }
  void do_set_gravity(const Eigen::Vector3d& gravity) override {
    gravity_ = gravity;
    tree_.set_gravity(0, gravity);
    if (fused_) fused_->set_gravity(gravity);
  }
  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    if (fused_) {
      fused_->forward_dynamics(q, v, tau, free_.data(), a, imbalance_.data());
    } else {
      tree_.forward_dynamics(q, v, tau, free_.data(), a, imbalance_.data());
    }
  }
  void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) override {
    tree_.inverse_dynamics(q, v, a, tau);
  }
  void do_mass_matrix(const double* q, Eigen::MatrixXd& mass) override {
    mass.resize(dof(), dof());
    tree_.mass_matrix(q, mass.data());  // symmetric, so row-major and column-major agree
  }
  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override { tree_.body_poses(q, poses); }

  Energy do_energy(const double* q, const double* v) override {
    Eigen::MatrixXd mass;
    do_mass_matrix(q, mass);
    const Eigen::Map<const Eigen::VectorXd> rate(v, dof());
    Energy energy;
    energy.kinetic = 0.5 * rate.dot(mass * rate);
    std::vector<Eigen::Isometry3d> poses;
    tree_.body_poses(q, poses);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      energy.potential -= masses_[i].mass * gravity_.dot(poses[i] * masses_[i].com);
    }
    return energy;
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    const std::size_t n = dof();
    std::vector<double> a(n);
    if (integrator == "semi_implicit_euler") {
      do_forward_dynamics(q, v, tau, a.data());
      for (std::size_t i = 0; i < n; ++i) {
        v[i] += step * a[i];
        q[i] += step * v[i];
      }
      return;
    }
    if (integrator != "rk4") throw std::invalid_argument("featherstone has no integrator " + integrator);
    classic_runge_kutta(q, v, tau, step);
  }

 private:
  /// Kutta's fourth-order method with tau held.
  void classic_runge_kutta(double* q, double* v, const double* tau, double h) {
    const Eigen::Index n = dof();
    Eigen::Map<Eigen::VectorXd> position(q, n), rate(v, n);
    const Eigen::VectorXd q0 = position, v0 = rate;
    Eigen::VectorXd dq = Eigen::VectorXd::Zero(n), dv = dq, stage_q = q0, stage_v = v0, a(n);
    const double nodes[4] = {0.5, 0.5, 1.0, 0.0}, weights[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int k = 0; k < 4; ++k) {
      do_forward_dynamics(stage_q.data(), stage_v.data(), tau, a.data());
      dq += weights[k] * stage_v;
      dv += weights[k] * a;
      const Eigen::VectorXd next_q = q0 + h * nodes[k] * stage_v;
      stage_v = v0 + h * nodes[k] * a;
      stage_q = next_q;
    }
    position = q0 + h * dq;
    rate = v0 + h * dv;
  }

  Tree<double> tree_;
  std::vector<Inertial> masses_;
  std::vector<double> free_, imbalance_;
  Eigen::Vector3d gravity_;
  std::unique_ptr<ForwardKernel> fused_;  ///< forward dynamics where the CPU can fuse, else null
};

class FeatherstoneEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "featherstone";
    info.version = "lacuna";
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", true, "articulated-body algorithm, joints may be held"},
        {"inverse_dynamics", true, "recursive Newton-Euler"},
        {"mass_matrix", true, "composite-rigid-body algorithm"},
        {"inertials_in_place", true, "nothing is rebuilt"},
        {"gravity_in_place", true, "nothing is rebuilt"},
        {"lanes", true, "many parameter sets at once in SIMD lanes"},
    };
    info.own_models = {
        {"joint damping", "none: an actuator's or an effect's"},
        {"friction loss", "none: an effect's, joints stick and slip exactly"},
        {"joint limits", "none: an effect's"},
        {"armature", "on the diagonal of the articulated inertia; 0 unless an effect says otherwise"},
    };
    info.native_integrators = {"rk4", "semi_implicit_euler"};
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    return std::make_unique<FeatherstoneDynamics>(std::move(robot), gravity);
  }
};

}  // namespace

const Engine& featherstone_engine() {
  static const FeatherstoneEngine engine;
  return engine;
}

}  // namespace lacuna
