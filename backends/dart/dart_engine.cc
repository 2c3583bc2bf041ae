// DART 6.12 as an acceleration oracle: a Skeleton of RevoluteJoint and PrismaticJoint, Featherstone's algorithm in
// generalised coordinates. Native steps run in a simulation::World whose only skeleton has no shapes.
//
// DART hands Eigen types across its binary interface. Its package is compiled for the plain architecture, so they are
// aligned to 16 bytes, and so are ours whatever instruction set a file is compiled for (EIGEN_MAX_ALIGN_BYTES, asserted
// below).
#include <fmt/format.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/StdVector>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16, "DART's package aligns Eigen's types to 16 bytes");

// Debian's DART is built with its assertions, and some of its classes have virtual functions that only exist then: what
// is compiled here must see the same, so NDEBUG is off for its headers (not for Eigen's, above) whatever it is for us.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <dart/config.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/DegreeOfFreedom.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/simulation/World.hpp>
#pragma pop_macro("NDEBUG")

#include "backends/least_inertia.h"
#include "backends/registry.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// DART's assertions end the program at numbers that overflowed; beyond this the answer is not a number instead. What it
// multiplies, four of them at most, stays far from 1e308.
constexpr double largest_input = 1e30;

// They end it, too, where a joint moves no inertia at all. What is missing of a principal moment is raised to this part
// of the body's inertia about its own frame, so accelerations of a point mass move by 1e-12 of their size.
constexpr double least_inertia = 1e-12;

bool usable(const double* numbers, int n) {
  return std::all_of(numbers, numbers + n, [](double x) { return std::abs(x) < largest_input; });
}

Eigen::Map<const Eigen::VectorXd> vector(const double* numbers, int n) { return {numbers, n}; }

// DART does not say whether several threads may make worlds at once: one at a time.
std::mutex& building() {
  static std::mutex mutex;
  return mutex;
}

class DartDynamics final : public Dynamics {
 public:
  DartDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity,
               const std::vector<Inertial>& inertials)
      : Dynamics(robot), shared_(std::move(robot)), inertials_(inertials), rest_(Eigen::VectorXd::Zero(dof())) {
    const std::lock_guard lock(building());
    skeleton_ = dart::dynamics::Skeleton::create("robot");
    skeleton_->setGravity(gravity);
    for (int i = 0; i < dof(); ++i) add_body(i);
  }
  ~DartDynamics() override {
    const std::lock_guard lock(building());
    world_.reset();
    skeleton_.reset();
  }
  DartDynamics(const DartDynamics&) = delete;

  std::unique_ptr<Dynamics> clone() const override {
    auto out = std::make_unique<DartDynamics>(shared_, skeleton_->getGravity(), inertials_);
    out->losses_ = losses_;
    return out;
  }

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    inertials_[body] = inertial;
    body_node(body)->setInertia(to_dart(inertial));
  }

  void do_set_own_losses(std::span<const JointLoss> losses) override { losses_.assign(losses.begin(), losses.end()); }

  void do_set_gravity(const Eigen::Vector3d& gravity) override { skeleton_->setGravity(gravity); }

  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    if (!usable(q, dof()) || !usable(v, dof()) || !usable(tau, dof())) return not_a_number(a);
    set_state(q, v);
    skeleton_->setForces(vector(tau, dof()));
    skeleton_->computeForwardDynamics();
    Eigen::Map<Eigen::VectorXd>(a, dof()) = skeleton_->getAccelerations();
  }

  void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) override {
    if (!usable(q, dof()) || !usable(v, dof()) || !usable(a, dof())) return not_a_number(tau);
    set_state(q, v);
    skeleton_->setAccelerations(vector(a, dof()));
    skeleton_->computeInverseDynamics();
    Eigen::Map<Eigen::VectorXd>(tau, dof()) = skeleton_->getForces();
  }

  void do_mass_matrix(const double* q, Eigen::MatrixXd& mass) override {
    mass.setConstant(nan);
    if (!usable(q, dof())) return;
    set_state(q, rest_.data());
    mass = skeleton_->getMassMatrix();
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    if (!usable(q, dof())) {
      for (Eigen::Isometry3d& pose : poses) pose.matrix().setConstant(nan);
      return;
    }
    set_state(q, rest_.data());
    for (int i = 0; i < dof(); ++i) poses[i] = body_node(i)->getWorldTransform();
  }

  Energy do_energy(const double* q, const double* v) override {
    if (!usable(q, dof()) || !usable(v, dof())) return {nan, nan};
    set_state(q, v);
    // DART's own potential energy takes each body's mass to be at the origin of its frame.
    double potential = 0.0;
    for (int i = 0; i < dof(); ++i) {
      potential -= body_node(i)->getMass() * skeleton_->getGravity().dot(body_node(i)->getCOM());
    }
    return {skeleton_->computeKineticEnergy(), potential};
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    if (integrator != "semi_implicit_euler") {
      throw std::invalid_argument("dart: integrator " + quoted(integrator) + ", expected semi_implicit_euler");
    }
    if (!usable(q, dof()) || !usable(v, dof()) || !usable(tau, dof())) {
      not_a_number(q);
      return not_a_number(v);
    }
    make_world();
    set_state(q, v);
    skeleton_->setForces(vector(tau, dof()));
    world_->setTimeStep(step);
    put_losses(1.0);
    world_->step();
    put_losses(0.0);
    Eigen::Map<Eigen::VectorXd>(q, dof()) = skeleton_->getPositions();
    Eigen::Map<Eigen::VectorXd>(v, dof()) = skeleton_->getVelocities();
  }

 private:
  dart::dynamics::BodyNode* body_node(int index) { return skeleton_->getBodyNode(static_cast<std::size_t>(index)); }

  // Number by number: given as a matrix, moments that a table rounded draw warnings on the console.
  static dart::dynamics::Inertia to_dart(const Inertial& inertial) {
    const Eigen::Vector3d& com = inertial.com;
    const Eigen::Matrix3d moment = with_least_inertia(inertial, least_inertia);
    return {inertial.mass, com.x(),      com.y(),      com.z(),      moment(0, 0),
            moment(1, 1),  moment(2, 2), moment(0, 1), moment(0, 2), moment(1, 2)};
  }

  template <class Joint>
  void add_joint(dart::dynamics::BodyNode* parent, typename Joint::Properties properties,
                 const dart::dynamics::BodyNode::AspectProperties& body) {
    skeleton_->createJointAndBodyNodePair<Joint>(parent, properties, dart::dynamics::BodyNode::Properties(body));
  }

  void add_body(int index) {
    const Joint& joint = robot().joints()[index];
    dart::dynamics::BodyNode* const parent = joint.parent < 0 ? nullptr : body_node(joint.parent);
    const dart::dynamics::BodyNode::AspectProperties body(fmt::format("b{}", index), to_dart(inertials_[index]));
    const auto place = [&](auto properties) {
      properties.mName = fmt::format("j{}", index);
      properties.mAxis = joint.axis;
      properties.mT_ParentBodyToJoint = joint.origin;
      return properties;
    };
    if (joint.prismatic()) {
      add_joint<dart::dynamics::PrismaticJoint>(parent, place(dart::dynamics::PrismaticJoint::Properties()), body);
    } else {
      add_joint<dart::dynamics::RevoluteJoint>(parent, place(dart::dynamics::RevoluteJoint::Properties()), body);
    }
  }

  // Only for a step: DART's accelerations would have the damping in them, too.
  void put_losses(double share) {
    for (std::size_t i = 0; i < losses_.size(); ++i) {
      skeleton_->getDof(i)->setDampingCoefficient(share * losses_[i].damping);
      skeleton_->getDof(i)->setCoulombFriction(share * losses_[i].friction);
    }
  }

  void make_world() {
    if (world_) return;
    const std::lock_guard lock(building());
    world_ = dart::simulation::World::create();
    const Eigen::Vector3d gravity = skeleton_->getGravity();
    world_->setGravity(gravity);  // it hands its own on to what is added
    world_->addSkeleton(skeleton_);
  }

  void set_state(const double* q, const double* v) {
    skeleton_->setPositions(vector(q, dof()));
    skeleton_->setVelocities(vector(v, dof()));
  }
  void not_a_number(double* out) const { std::fill_n(out, dof(), nan); }

  std::shared_ptr<const Robot> shared_;
  std::vector<Inertial> inertials_;
  std::vector<JointLoss> losses_;
  Eigen::VectorXd rest_;
  dart::dynamics::SkeletonPtr skeleton_;
  dart::simulation::WorldPtr world_;  // of native steps, made at the first
};

class DartEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "dart";
    info.version = DART_VERSION;
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", true, "articulated-body algorithm, O(n)"},
        {"inverse_dynamics", true, "recursive Newton-Euler"},
        {"energy", false, "kinetic itself; its own potential energy leaves out where in the body the mass is"},
        {"mass_matrix", true, "column by column, by recursive Newton-Euler"},
        {"inertials_in_place", true, "BodyNode::setInertia, nothing is rebuilt"},
        {"gravity_in_place", true, "nothing is rebuilt"},
        {"point_masses", false, "a missing principal inertia is raised to 1e-12 of the body's own about its frame"},
    };
    info.own_models = {
        {"joint damping", "effort -b v at a joint's degree of freedom, implicit (M + h b) in its steps; 0 here"},
        {"friction loss", "a constraint of bounded effort at the joint (setCoulombFriction); 0 here"},
        {"joint limits", "rows of the boxed LCP; not enforced here"},
        {"armature", "none"},
    };
    info.own_losses = true;
    info.native_integrators = {"semi_implicit_euler"};
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    std::vector<Inertial> inertials;
    inertials.reserve(robot->dof());
    for (int i = 0; i < robot->dof(); ++i) inertials.push_back(robot->body_inertial(i));
    return std::make_unique<DartDynamics>(std::move(robot), gravity, inertials);
  }
};

}  // namespace

const Engine& dart_engine() {
  static const DartEngine engine;
  return engine;
}

}  // namespace lacuna
