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
bool operator==(const Index& a, const Index& b) { return static_cast<int>(a) == static_cast<int>(b); }
}  // namespace SimTK

// Debian's Simbody is built with its assertions, and its State is laid out differently without (StateImpl.h): inline
// functions compiled here must see the same layout, so NDEBUG is off for the headers whatever it is for us.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <Simbody.h>
#pragma pop_macro("NDEBUG")

#include <Eigen/Eigenvalues>
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

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

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

// Simbody refuses an inertia that no matter can have, even by the rounding of a printed table (which Robot lets pass).
// Of such a one the second moment of mass that came out negative is made zero: the two other principal moments grow by
// half of what the triangle inequality lacked.
Eigen::Matrix3d possible(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia);
  const Eigen::Vector3d second = Eigen::Vector3d::Constant(0.5 * inertia.trace()) - principal.eigenvalues();
  if (second.minCoeff() >= 0.0) return inertia;
  const Eigen::Vector3d clamped = second.cwiseMax(0.0);
  const Eigen::Vector3d moments = Eigen::Vector3d::Constant(clamped.sum()) - clamped;
  return principal.eigenvectors() * moments.asDiagonal() * principal.eigenvectors().transpose();
}

// Simbody's inertia is about the body's origin, not about the centre of mass.
SimTK::MassProperties mass_properties(const Inertial& body) {
  const Eigen::Vector3d& c = body.com;
  const Eigen::Matrix3d about_origin =
      possible(body.inertia) + body.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  const SimTK::Inertia inertia(about_origin(0, 0), about_origin(1, 1), about_origin(2, 2), about_origin(0, 1),
                               about_origin(0, 2), about_origin(1, 2));
  return {body.mass, vec(c), inertia};
}

bool finite(const double* numbers, int n) {
  return std::all_of(numbers, numbers + n, [](double x) { return std::isfinite(x); });
}

// Simbody throws where its own checks meet numbers that overflowed. The answer is then not a number, as elsewhere.
template <class Work>
bool survived(const Work& work) {
  try {
    work();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

// Building a system and taking it down touch Simbody's static tables: one thread at a time.
std::mutex& building() {
  static std::mutex mutex;
  return mutex;
}

// One thread a system: Simbody would otherwise start as many as there are processors, for two forces.
struct Forces : SimTK::GeneralForceSubsystem {
  explicit Forces(SimTK::MultibodySystem& system) : SimTK::GeneralForceSubsystem(system) { setNumberOfThreads(1); }
};

// The parts refer to each other and register themselves with the system, so they are made once and never moved.
struct World {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  Forces forces{system};
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
    inertials_[body] = inertial;
    world_->bodies[body].setDefaultMassProperties(mass_properties(inertial));
    stale_ = true;
  }

  void do_set_gravity(const Eigen::Vector3d& gravity) override {
    gravity_ = gravity;
    if (!stale_) world_->gravity.setGravityVector(state_, vec(gravity));
  }

  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    not_a_number(a);
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(tau, dof())) return;
    survived([&] {
      set_state(q, v, tau);
      world_->system.realize(state_, SimTK::Stage::Acceleration);
      gather(state_.getUDot(), a);
    });
  }

  void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau) override {
    const std::vector<double> wanted(a, a + dof());  // `a` and `tau` may be one array
    not_a_number(tau);
    if (!finite(q, dof()) || !finite(v, dof()) || !finite(wanted.data(), dof())) return;
    survived([&] {
      set_state(q, v, nullptr);
      world_->system.realize(state_, SimTK::Stage::Velocity);
      scatter(wanted.data(), buffer_);
      SimTK::Vector residual;
      world_->matter.calcResidualForceIgnoringConstraints(state_, SimTK::Vector(),
                                                          world_->gravity.getBodyForces(state_), buffer_, residual);
      gather(residual, tau);
    });
  }

  void do_mass_matrix(const double* q, Eigen::MatrixXd& mass) override {
    mass.setConstant(nan);
    if (!finite(q, dof())) return;
    survived([&] {
      set_state(q, nullptr, nullptr);
      world_->system.realize(state_, SimTK::Stage::Position);
      SimTK::Matrix theirs;
      world_->matter.calcM(state_, theirs);
      for (int i = 0; i < dof(); ++i) {
        for (int j = 0; j < dof(); ++j) mass(i, j) = theirs(slot(i), slot(j));
      }
    });
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    for (Eigen::Isometry3d& pose : poses) pose.matrix().setConstant(nan);
    if (!finite(q, dof())) return;
    survived([&] {
      set_state(q, nullptr, nullptr);
      world_->system.realize(state_, SimTK::Stage::Position);
      for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = pose_of(world_->bodies[i]);
    });
  }

  Energy do_energy(const double* q, const double* v) override {
    Energy energy{nan, nan};
    if (!finite(q, dof()) || !finite(v, dof())) return energy;
    survived([&] {
      set_state(q, v, nullptr);
      world_->system.realize(state_, SimTK::Stage::Velocity);
      double potential = 0.0;
      for (std::size_t i = 0; i < inertials_.size(); ++i) {
        const SimTK::Vec3 com = world_->bodies[i].findMassCenterLocationInGround(state_);
        potential -= inertials_[i].mass * SimTK::dot(vec(gravity_), com);
      }
      energy = {world_->matter.calcKineticEnergy(state_), potential};
    });
    return energy;
  }

  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    const std::size_t which = integrator_index(integrator);
    const bool usable = finite(q, dof()) && finite(v, dof()) && finite(tau, dof());
    if (usable && survived([&] { step_natively(which, q, v, tau, step); })) return;
    not_a_number(q);
    not_a_number(v);
  }

 private:
  int slot(int joint) const { return slots_[joint]; }

  void add_body(int index) {
    const Joint& joint = robot().joints()[index];
    // Pin turns about the z axis of its frames, Slider moves along x: turn that axis into the joint's.
    const Eigen::Vector3d own = joint.prismatic() ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d to_axis = Eigen::Quaterniond::FromTwoVectors(own, joint.axis).toRotationMatrix();
    const SimTK::Transform in_parent(rotation(joint.origin.linear() * to_axis), vec(joint.origin.translation()));
    const SimTK::Transform in_body(rotation(to_axis));
    const SimTK::Body::Rigid rigid(mass_properties(inertials_[index]));
    SimTK::MobilizedBody& parent = joint.parent < 0 ? static_cast<SimTK::MobilizedBody&>(world_->matter.updGround())
                                                    : world_->bodies[joint.parent];
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
  void not_a_number(double* out) const { std::fill_n(out, dof(), nan); }

  Eigen::Isometry3d pose_of(const SimTK::MobilizedBody& body) const {
    const SimTK::Transform& theirs = body.getBodyTransform(state_);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) pose.linear()(r, c) = theirs.R().asMat33()(r, c);
      pose.translation()[r] = theirs.p()[r];
    }
    return pose;
  }

  static std::size_t integrator_index(const std::string& name) {
    for (std::size_t i = 0; i < integrators.size(); ++i) {
      if (name == integrators[i].name) return i;
    }
    throw std::invalid_argument("simbody: integrator " + quoted(name) + " is not one of those it has");
  }

  // A step without error control, begun anew so that nothing remains of the step before.
  void step_natively(std::size_t which, double* q, double* v, const double* tau, double step) {
    set_state(q, v, tau);
    std::unique_ptr<SimTK::Integrator>& native = integrators_[which];
    if (!native) native = integrators[which].make(world_->system);
    native->setFixedStepSize(step);
    native->initialize(state_);
    while (native->getTime() < step) native->stepTo(step);  // the first call only reports the start
    gather(native->getState().getQ(), q);
    gather(native->getState().getU(), v);
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
        {"native_step", true, "begun anew at each call, which is most of its cost here"},
        {"rounded_inertias", false,
         "moments that a printed table rounded beyond the triangle inequality are raised to it"},
    };
    info.own_models = {
        {"joint damping", "a force element, -c u (Force::MobilityLinearDamper); none is made"},
        {"friction loss", "none for joints; a user's own force element or constraint"},
        {"joint limits", "a force element with stiffness and dissipation (Force::MobilityLinearStop); none is made"},
        {"armature", "none"},
    };
    for (const NativeIntegrator& integrator : integrators) info.native_integrators.emplace_back(integrator.name);
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    std::vector<Inertial> inertials;
    inertials.reserve(robot->dof());
    for (int i = 0; i < robot->dof(); ++i) inertials.push_back(robot->body_inertial(i));
    const std::string name = robot->name();
    try {
      return std::make_unique<SimbodyDynamics>(std::move(robot), gravity, std::move(inertials));
    } catch (const SimTK::Exception::Base& error) {
      throw WorkError("simbody cannot hold robot " + quoted(name) + ": " + quoted(error.what(), 200));
    }
  }
};

}  // namespace

const Engine& simbody_engine() {
  static const SimbodyEngine engine;
  return engine;
}

}  // namespace lacuna
