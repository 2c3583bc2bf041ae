// Simbody 3.7 as an acceleration oracle: a Pin or Slider mobilizer a joint, forces by Force::Gravity and
// Force::DiscreteForces, everything else by Simbody's own O(n) operators.
//
// Simbody keeps mass properties in its topology: a change of them makes the next call realize the topology anew.

// Simbody's headers compare index types, which have operator== for every integer type and a conversion to int: among
// these, C++20's reversed operators leave no best candidate. This exact one, declared before them, is it.
namespace SimTK {
template <class Index>
  requires requires(const Index& index) {
    index.isValidExtended();
    static_cast<int>(index);
  }
bool operator==(const Index& a, const Index& b) {
  return static_cast<int>(a) == static_cast<int>(b);
}
}  // namespace SimTK

#include <Simbody.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "backends/registry.h"
#include "scenarios/error.h"

// No `using namespace SimTK`: its operator templates would take over Eigen's.
namespace lacuna {
namespace {

struct NativeIntegrator {
  const char* name;
  std::unique_ptr<SimTK::Integrator> (*make)(const SimTK::System&);
};
template <class T>
std::unique_ptr<SimTK::Integrator> make_integrator(const SimTK::System& system) {
  return std::make_unique<T>(system);
}
std::unique_ptr<SimTK::Integrator> make_semi_explicit_euler(const SimTK::System& system) {
  return std::make_unique<SimTK::SemiExplicitEulerIntegrator>(system, 1.0);  // its step is set with every call
}
constexpr std::array<NativeIntegrator, 5> integrators = {{
    {"runge_kutta_merson", &make_integrator<SimTK::RungeKuttaMersonIntegrator>},
    {"runge_kutta_feldberg", &make_integrator<SimTK::RungeKuttaFeldbergIntegrator>},
    {"runge_kutta_3", &make_integrator<SimTK::RungeKutta3Integrator>},
    {"semi_explicit_euler", &make_semi_explicit_euler},
    {"explicit_euler", &make_integrator<SimTK::ExplicitEulerIntegrator>},
}};

SimTK::Vec3 vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

SimTK::Rotation rotation(const Eigen::Matrix3d& r) {
  const SimTK::Mat33 m(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2));
  return SimTK::Rotation(m, true);  // as it is: already orthonormal
}

// Simbody's inertia is about the body's origin, not about the centre of mass.
SimTK::MassProperties mass_properties(const Inertial& body) {
  const Eigen::Vector3d& c = body.com;
  const Eigen::Matrix3d about_origin =
      body.inertia + body.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  const SimTK::Inertia inertia(about_origin(0, 0), about_origin(1, 1), about_origin(2, 2), about_origin(0, 1),
                               about_origin(0, 2), about_origin(1, 2));
  return {body.mass, vec(c), inertia};
}

bool finite(const double* numbers, int n) {
  return std::all_of(numbers, numbers + n, [](double x) { return std::isfinite(x); });
}

// Building a system and taking it down touch Simbody's static tables: one thread at a time.
std::mutex& building() {
  static std::mutex mutex;
  return mutex;
}

// The parts refer to each other and register themselves with the system, so they are made once and never moved.
struct World {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  SimTK::Force::Gravity gravity{forces, matter, SimTK::Vec3(0, 0, -1)};
  SimTK::Force::DiscreteForces effort{forces, matter};
  std::vector<SimTK::MobilizedBody> bodies;
};

class SimbodyDynamics final : public Dynamics {
 public:
  SimbodyDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity, std::vector<Inertial> inertials)
      : Dynamics(robot), shared_(std::move(robot)), inertials_(std::move(inertials)), gravity_(gravity) {
    const std::lock_guard lock(building());
    world_ = std::make_unique<World>();
    for (int i = 0; i < dof(); ++i) add_body(i);
    realize_topology();
  }
  ~SimbodyDynamics() override {
    const std::lock_guard lock(building());
    integrators_ = {};
    world_.reset();
  }
  SimbodyDynamics(const SimbodyDynamics&) = delete;

  std::unique_ptr<Dynamics> clone() const override {
    return std::make_unique<SimbodyDynamics>(shared_, gravity_, inertials_);
  }

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    inertials_[static_cast<std::size_t>(body)] = inertial;
    world_->bodies[static_cast<std::size_t>(body)].setDefaultMassProperties(mass_properties(inertial));
    stale_ = true;
  }

  void do_set_gravity(const Eigen::Vector3d& gravity) override {
    gravity_ = gravity;
    if (!stale_) world_->gravity.setGravityVector(state_, vec(gravity));
  }

  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(tau, dof())) return not_a_number(a);
    set_state(q, v, tau);
    world_->system.realize(state_, SimTK::Stage::Acceleration);
    gather(state_.getUDot(), a);
  }

  void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) override {
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(a, dof())) return not_a_number(tau);
    set_state(q, v, nullptr);
    world_->system.realize(state_, SimTK::Stage::Velocity);
    for (int i = 0; i < dof(); ++i) buffer_[slot(i)] = a[i];
    SimTK::Vector residual;
    world_->matter.calcResidualForceIgnoringConstraints(state_, SimTK::Vector(), world_->gravity.getBodyForces(state_),
                                                        buffer_, residual);
    gather(residual, tau);
  }

  void do_mass_matrix(const double* q, Eigen::MatrixXd& mass) override {
    if (!finite(q, dof())) {
      mass.setConstant(std::numeric_limits<double>::quiet_NaN());
      return;
    }
    set_state(q, nullptr, nullptr);
    world_->system.realize(state_, SimTK::Stage::Position);
    SimTK::Matrix theirs;
    world_->matter.calcM(state_, theirs);
    for (int i = 0; i < dof(); ++i) {
      for (int j = 0; j < dof(); ++j) mass(i, j) = theirs(slot(i), slot(j));
    }
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    set_state(q, nullptr, nullptr);
    world_->system.realize(state_, SimTK::Stage::Position);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const SimTK::Transform& pose = world_->bodies[i].getBodyTransform(state_);
      poses[i].setIdentity();
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) poses[i].linear()(r, c) = pose.R().asMat33()(r, c);
        poses[i].translation()[r] = pose.p()[r];
      }
    }
  }

  Energy do_energy(const double* q, const double* v) override {
    set_state(q, v, nullptr);
    world_->system.realize(state_, SimTK::Stage::Velocity);
    Energy energy;
    energy.kinetic = world_->matter.calcKineticEnergy(state_);
    for (std::size_t i = 0; i < inertials_.size(); ++i) {
      const SimTK::Vec3 com = world_->bodies[i].findMassCenterLocationInGround(state_);
      energy.potential -= inertials_[i].mass * SimTK::dot(vec(gravity_), com);
    }
    return energy;
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(tau, dof())) {
      not_a_number(q);
      return not_a_number(v);
    }
    set_state(q, v, tau);
    SimTK::Integrator& native = find_integrator(integrator);
    // A step without error control, begun anew so that nothing remains of the step before.
    native.setFixedStepSize(step);
    native.initialize(state_);
    native.stepTo(step);
    gather(native.getState().getQ(), q);
    gather(native.getState().getU(), v);
  }

 private:
  int slot(int joint) const { return slots_[static_cast<std::size_t>(joint)]; }

  void add_body(int index) {
    const Joint& joint = robot().joints()[static_cast<std::size_t>(index)];
    // Pin turns about the z axis of its frames, Slider moves along x: turn that axis into the joint's.
    const Eigen::Vector3d own = joint.prismatic() ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d to_axis = Eigen::Quaterniond::FromTwoVectors(own, joint.axis).toRotationMatrix();
    const SimTK::Transform in_parent(rotation(joint.origin.linear() * to_axis), vec(joint.origin.translation()));
    const SimTK::Transform in_body(rotation(to_axis));
    const SimTK::Body::Rigid rigid(mass_properties(inertials_[static_cast<std::size_t>(index)]));
    SimTK::MobilizedBody& parent = joint.parent < 0 ? static_cast<SimTK::MobilizedBody&>(world_->matter.updGround())
                                                    : world_->bodies[static_cast<std::size_t>(joint.parent)];
    if (joint.prismatic()) {
      world_->bodies.push_back(SimTK::MobilizedBody::Slider(parent, in_parent, rigid, in_body));
    } else {
      world_->bodies.push_back(SimTK::MobilizedBody::Pin(parent, in_parent, rigid, in_body));
    }
  }

  void realize_topology() {
    integrators_ = {};
    state_ = world_->system.realizeTopology();
    world_->gravity.setGravityVector(state_, vec(gravity_));
    world_->system.realizeModel(state_);
    slots_.clear();
    for (const SimTK::MobilizedBody& body : world_->bodies) slots_.push_back(body.getFirstUIndex(state_));
    buffer_.resize(dof());
    stale_ = false;
  }

  // A null pointer stands for zeros.
  void set_state(const double* q, const double* v, const double* tau) {
    if (stale_) {
      const std::lock_guard lock(building());
      realize_topology();
    }
    state_.setTime(0.0);
    scatter(q, state_.updQ());
    scatter(v, state_.updU());
    scatter(tau, buffer_);
    world_->effort.setAllMobilityForces(state_, buffer_);
  }
  void scatter(const double* ours, SimTK::Vector& theirs) const {
    for (int i = 0; i < dof(); ++i) theirs[slot(i)] = ours == nullptr ? 0.0 : ours[i];
  }
  void gather(const SimTK::Vector& theirs, double* ours) const {
    for (int i = 0; i < dof(); ++i) ours[i] = theirs[slot(i)];
  }
  void not_a_number(double* out) const { std::fill_n(out, dof(), std::numeric_limits<double>::quiet_NaN()); }

  SimTK::Integrator& find_integrator(const std::string& name) {
    for (std::size_t i = 0; i < integrators.size(); ++i) {
      if (name != integrators[i].name) continue;
      if (!integrators_[i]) integrators_[i] = integrators[i].make(world_->system);
      return *integrators_[i];
    }
    throw std::invalid_argument("simbody: integrator " + quoted(name) + " is not one of those it has");
  }

  std::shared_ptr<const Robot> shared_;
  std::vector<Inertial> inertials_;
  Eigen::Vector3d gravity_;
  std::unique_ptr<World> world_;
  SimTK::State state_;
  std::vector<int> slots_;  // where a joint's q and u stand in Simbody's vectors
  SimTK::Vector buffer_;
  std::array<std::unique_ptr<SimTK::Integrator>, integrators.size()> integrators_;
  bool stale_ = false;  // mass properties changed since the topology was realized
};

class SimbodyEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "simbody";
    int major = 0, minor = 0, build = 0;
    SimTK_version_simbody(&major, &minor, &build);
    info.version = std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(build);
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", true, "recursive articulated bodies, O(n)"},
        {"inverse_dynamics", true, "calcResidualForce, O(n)"},
        {"mass_matrix", true, "calcM"},
        {"inertials_in_place", false, "Simbody keeps them in its topology, realized anew before the next call"},
        {"gravity_in_place", true, "a state variable, nothing is rebuilt"},
    };
    for (const NativeIntegrator& integrator : integrators) info.native_integrators.emplace_back(integrator.name);
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    std::vector<Inertial> inertials;
    for (int i = 0; i < robot->dof(); ++i) inertials.push_back(robot->body_inertial(i));
    return std::make_unique<SimbodyDynamics>(std::move(robot), gravity, std::move(inertials));
  }
};

}  // namespace

const Engine& simbody_engine() {
  static const SimbodyEngine engine;
  return engine;
}

}  // namespace lacuna
