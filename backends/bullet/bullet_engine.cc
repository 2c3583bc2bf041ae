// Bullet 3.24 in double precision as an acceleration oracle: btMultiBody, Featherstone's algorithm over links that are
// each placed at their centre of mass, along the principal axes of their inertia.
//
// A btMultiBody needs no world to compute accelerations: gravity is a force at each link's centre of mass, as Bullet's
// world applies it, too. Native steps run in a btMultiBodyDynamicsWorld without shapes, so that nothing collides.
//
// What Bullet adds of its own is off: linear and angular damping (0.04 by default), the clamp of joint rates (100 rad/s
// by default), sleeping. Numbers are btScalar, which BT_USE_DOUBLE_PRECISION makes double: as the package's float64
// libraries were built.
#define BT_USE_DOUBLE_PRECISION
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletCollisionCommon.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "backends/registry.h"
#include "scenarios/error.h"

static_assert(std::is_same_v<btScalar, double>);

namespace lacuna {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// rad/s, m/s: Bullet clamps joint rates to this after each step; beyond it a motion is lost anyway.
constexpr double fastest = 1e150;

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btQuaternion turn_of(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond turn(rotation);
  return {turn.x(), turn.y(), turn.z(), turn.w()};
}

bool finite(const double* numbers, int n) {
  return std::all_of(numbers, numbers + n, [](double x) { return std::isfinite(x); });
}

// Where Bullet puts a link: its centre of mass and the principal axes of its inertia, both in our body frame.
struct Placement {
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // columns; what is (1, 0, 0) to Bullet is the first
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();   // kg m^2
};

Placement placement(const Inertial& inertial) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertial.inertia);
  Placement link{inertial.com, principal.eigenvectors(), principal.eigenvalues().cwiseMax(0.0)};
  if (link.axes.determinant() < 0) link.axes.col(2) = -link.axes.col(2);
  return link;
}

// A world without shapes. Its parts refer to each other and are taken down in reverse order.
struct World {
  explicit World(btMultiBody* body) { world.addMultiBody(body); }
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

class BulletDynamics final : public Dynamics {
 public:
  BulletDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity, std::vector<Inertial> inertials)
      : Dynamics(robot), shared_(std::move(robot)), inertials_(std::move(inertials)), gravity_(gravity) {
    make_body();
  }
  BulletDynamics(const BulletDynamics&) = delete;

  std::unique_ptr<Dynamics> clone() const override {
    return std::make_unique<BulletDynamics>(shared_, gravity_, inertials_);
  }

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    inertials_[body] = inertial;
    stale_ = true;
  }

  void do_set_gravity(const Eigen::Vector3d& gravity) override { gravity_ = gravity; }

  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(tau, dof())) return not_a_number(a);
    set_state(q, v);
    apply(tau);
    for (int i = 0; i < dof(); ++i) {
      body_->addLinkForce(i, to_bullet(inertials_[i].mass * gravity_));
    }
    // A step of no length changes no rate; the accelerations are left behind the joints' scratch numbers, after six of
    // the base.
    body_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0.0, numbers_, vectors_, matrices_, false, false,
                                                                false);
    for (int i = 0; i < dof(); ++i) a[i] = numbers_[dof() + 6 + i];
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    if (!finite(q, dof())) {
      for (Eigen::Isometry3d& pose : poses) pose.matrix().setConstant(nan);
      return;
    }
    set_state(q, nullptr);
    body_->forwardKinematics(turns_, vectors_);
    for (int i = 0; i < dof(); ++i) poses[i] = pose_of(i);
  }

  Energy do_energy(const double* q, const double* v) override {
    if (!finite(q, dof()) || !finite(v, dof())) return {nan, nan};
    set_state(q, v);
    body_->forwardKinematics(turns_, vectors_);
    omega_.resize(dof() + 1);
    rate_.resize(dof() + 1);
    body_->compTreeLinkVelocities(&omega_[0], &rate_[0]);
    Energy energy;
    for (int i = 0; i < dof(); ++i) {
      const btMultibodyLink& link = body_->getLink(i);
      const btVector3 omega = omega_[i + 1];  // the base stands first
      energy.kinetic += 0.5 * link.m_mass * rate_[i + 1].length2() + 0.5 * omega.dot(link.m_inertiaLocal * omega);
      energy.potential -= link.m_mass * gravity_.dot(from_bullet(link.m_cachedWorldTransform.getOrigin()));
    }
    return energy;
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    const bool rk4 = integrator == "rk4";
    if (!rk4 && integrator != "semi_implicit_euler") {
      throw std::invalid_argument("bullet: integrator " + quoted(integrator) + ", expected semi_implicit_euler or rk4");
    }
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(tau, dof())) {
      not_a_number(q);
      return not_a_number(v);
    }
    set_state(q, v);
    apply(tau);
    if (!world_) world_ = std::make_unique<World>(body_.get());
    world_->world.setGravity(to_bullet(gravity_));
    body_->useRK4Integration(rk4);
    world_->world.stepSimulation(step, 0);  // 0: one step of just this length
    for (int i = 0; i < dof(); ++i) {
      q[i] = body_->getJointPos(i);
      v[i] = body_->getJointVel(i);
    }
  }

 private:
  // A btMultiBody's masses can be set in place, but not where its links' frames lie: so it is made anew.
  void make_body() {
    world_.reset();
    body_ = std::make_unique<btMultiBody>(dof(), 0.0, btVector3(0, 0, 0), true, false);
    links_.clear();
    for (int i = 0; i < dof(); ++i) add_link(i);
    body_->finalizeMultiDof();
    body_->setLinearDamping(0.0);
    body_->setAngularDamping(0.0);
    body_->setMaxCoordinateVelocity(fastest);
    stale_ = false;
  }

  void add_link(int index) {
    const Joint& joint = robot().joints()[index];
    const Inertial& inertial = inertials_[index];
    links_.push_back(placement(inertial));
    const Placement& link = links_.back();
    const Placement parent = joint.parent < 0 ? Placement{} : links_[joint.parent];
    const btQuaternion turn = turn_of(link.axes.transpose() * joint.origin.linear().transpose() * parent.axes);
    const btVector3 axis = to_bullet(link.axes.transpose() * joint.axis);
    const btVector3 to_joint = to_bullet(parent.axes.transpose() * (joint.origin.translation() - parent.com));
    const btVector3 to_com = to_bullet(link.axes.transpose() * link.com);
    const btVector3 moments = to_bullet(link.moments);
    if (joint.prismatic()) {
      body_->setupPrismatic(index, inertial.mass, moments, joint.parent, turn, axis, to_joint, to_com, true);
    } else {
      body_->setupRevolute(index, inertial.mass, moments, joint.parent, turn, axis, to_joint, to_com, true);
    }
  }

  // Joints at q and v (a null pointer: at rest), no forces.
  void set_state(const double* q, const double* v) {
    if (stale_) make_body();
    body_->clearForcesAndTorques();
    for (int i = 0; i < dof(); ++i) {
      body_->setJointPos(i, q[i]);
      body_->setJointVel(i, v == nullptr ? 0.0 : v[i]);
    }
  }
  void apply(const double* tau) {
    for (int i = 0; i < dof(); ++i) body_->addJointTorque(i, tau[i]);
  }

  Eigen::Isometry3d pose_of(int index) const {
    const btTransform& theirs = body_->getLink(index).m_cachedWorldTransform;
    Eigen::Matrix3d rotation;
    for (int r = 0; r < 3; ++r) rotation.row(r) = from_bullet(theirs.getBasis()[r]).transpose();
    const Placement& link = links_[index];
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = rotation * link.axes.transpose();
    pose.translation() = from_bullet(theirs.getOrigin()) - pose.linear() * link.com;
    return pose;
  }

  void not_a_number(double* out) const { std::fill_n(out, dof(), nan); }

  std::shared_ptr<const Robot> shared_;
  std::vector<Inertial> inertials_;
  Eigen::Vector3d gravity_;
  std::vector<Placement> links_;
  std::unique_ptr<btMultiBody> body_;
  std::unique_ptr<World> world_;  // of native steps, made at the first; holds body_, so it goes first
  btAlignedObjectArray<btScalar> numbers_;
  btAlignedObjectArray<btVector3> vectors_, omega_, rate_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
  btAlignedObjectArray<btQuaternion> turns_;
  bool stale_ = false;  // mass properties changed since the body was made
};

class BulletEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "bullet";
    info.version = fmt::format("{}.{:02}", btGetVersion() / 100, btGetVersion() % 100);
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", true, "articulated-body algorithm of btMultiBody, O(n)"},
        {"inverse_dynamics", false, "mass matrix times the acceleration that is missing from forward dynamics"},
        {"mass_matrix", false, "inverted from dof + 1 forward dynamics"},
        {"inertials_in_place", false, "links lie at their centres of mass: the multibody is made anew before use"},
        {"gravity_in_place", true, "a force at each centre of mass, nothing is rebuilt"},
    };
    info.own_models = {
        {"joint damping", "none at joints; bodies lose speed by setLinearDamping and setAngularDamping, 0 here"},
        {"friction loss",
         "a motor of speed 0 and bounded effort (btMultiBodyJointMotor), a row of the solver; none is "
         "made"},
        {"joint limits", "rows of the solver with ERP (btMultiBodyJointLimitConstraint); none is made"},
        {"armature", "none"},
    };
    info.native_integrators = {"semi_implicit_euler", "rk4"};
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    std::vector<Inertial> inertials;
    inertials.reserve(robot->dof());
    for (int i = 0; i < robot->dof(); ++i) inertials.push_back(robot->body_inertial(i));
    return std::make_unique<BulletDynamics>(std::move(robot), gravity, std::move(inertials));
  }
};

}  // namespace

const Engine& bullet_engine() {
  static const BulletEngine engine;
  return engine;
}

}  // namespace lacuna
