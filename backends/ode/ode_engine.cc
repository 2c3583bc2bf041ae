// ODE 0.16 as an acceleration oracle.
//
// ODE has no joint accelerations: it only steps bodies in maximal coordinates. A step of length h from body
// velocities V0 under forces f returns the V1 that holds the joints of the PRESENT configuration, J V1 = 0 (ERP = CFM
// = 0), and is nearest to V0 + h M^-1 f in the metric of the body masses M. With the joints' motion space V = S(q) v
// this is
//
//   V1 = S u,   u = (S' M S)^-1 S' (M V0 + h f).                                                                  (1)
//
// The true acceleration is a = (S' M S)^-1 S' (f - M dS/dt v). From V0 = S v, (u - v)/h would lack the second term
// whatever h: ODE gets it from the velocity carried over from the step before, which belongs to the configuration left
// behind, S(q - h v) v = S v - h dS/dt v + O(h^2). So that is what it is given here, without the O(h^2):
//
//   V0 = S v - h dS/dt v   =>   (u - v)/h = a   for every h.                                                      (2)
//
// The gyroscopic torque -w x I w is part of f. ODE's own is implicit in h (an error of relative size h |w|), so for the
// oracle it is switched off and the exact torque applied; for native steps ODE's own is on.
//
// Error of (2): no truncation, only rounding. u carries about eps |V|, so its quotient by h carries eps |V| / h: 1e-13
// for 10 rad/s and oracle_step = 10 ms; the solve adds eps kappa |a| with kappa the condition of J M^-1 J', the share
// of the constraint forces that cancels. Measured on random trees of 1 to 30 joints (tests/conformance), the worst of
// 1,000 states each is 6e-12 of |a|. A body without inertia of its own adds least_inertia, 1e-8.
#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "backends/least_inertia.h"
#include "backends/ode/tree_motion.h"
#include "backends/registry.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double oracle_step = 1e-2;  // s; any would do, see (2)

// ODE inverts every inertia, so a body may not lack one about any axis (a point mass, a thin rod). What is missing is
// raised to this part of the body's inertia about its own frame: accelerations move by less than about 1e-8 of their
// size, well under what ODE is asked for (1e-5).
constexpr double least_inertia = 1e-8;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Beyond this ODE's arithmetic overflows; the answer is not a number then.
constexpr double largest_input = 1e10;

void start_ode() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (dCheckConfiguration("ODE_double_precision") == 0) throw WorkError("ode: the library is not double precision");
    dInitODE2(0);
  });
}

void to_ode(const Eigen::Matrix3d& r, dMatrix3 out) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out[4 * i + j] = r(i, j);
    out[4 * i + 3] = 0.0;
  }
}
Eigen::Vector3d from_ode(const dReal* v) { return {v[0], v[1], v[2]}; }

bool usable(const double* numbers, int n) {
  return std::all_of(numbers, numbers + n, [](double x) { return std::abs(x) < largest_input; });
}

// Each world steps with a threading implementation of its own: ODE's default one is shared without locks.
class World {
 public:
  World() : threading_(dThreadingAllocateSelfThreadedImplementation()), id_(dWorldCreate()) {
    dWorldSetStepThreadingImplementation(id_, dThreadingImplementationGetFunctions(threading_), threading_);
    dWorldSetERP(id_, 0.0);
    dWorldSetCFM(id_, 0.0);
    dWorldSetAutoDisableFlag(id_, 0);
    dWorldSetDamping(id_, 0.0, 0.0);
  }
  ~World() {
    dWorldDestroy(id_);
    dThreadingFreeImplementation(threading_);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  dWorldID id() const { return id_; }

 private:
  dThreadingImplementationID threading_;
  dWorldID id_;
};

class OdeDynamics final : public Dynamics {
 public:
  OdeDynamics(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity, std::vector<Inertial> inertials)
      : Dynamics(robot), shared_(std::move(robot)), inertials_(std::move(inertials)), rest_(inertials_.size(), 0.0) {
    start_ode();
    world_ = std::make_unique<World>();
    do_set_gravity(gravity);
    for (int i = 0; i < dof(); ++i) add_body(i);
    anchor_joints();
  }
  OdeDynamics(const OdeDynamics&) = delete;

  std::unique_ptr<Dynamics> clone() const override {
    return std::make_unique<OdeDynamics>(shared_, gravity_, inertials_);
  }

 protected:
  void do_set_inertial(int body, const Inertial& inertial) override {
    inertials_[body] = inertial;
    write_mass(static_cast<std::size_t>(body));
    anchor_joints();
  }

  void do_set_gravity(const Eigen::Vector3d& gravity) override {
    gravity_ = gravity;
    dWorldSetGravity(world_->id(), gravity.x(), gravity.y(), gravity.z());
  }

  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    if (!usable(q, dof()) || !usable(v, dof()) || !usable(tau, dof())) return not_a_number(a);
    place(q, v, oracle_step);
    apply_efforts(tau);
    apply_gyroscopic_torques();
    dWorldStep(world_->id(), oracle_step);
    for (std::size_t i = 0; i < bodies_.size(); ++i) a[i] = (joint_rate(i) - v[i]) / oracle_step;
  }

  void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) override {
    if (!usable(q, dof())) {
      for (Eigen::Isometry3d& pose : poses) pose.matrix().setConstant(std::numeric_limits<double>::quiet_NaN());
      return;
    }
    place(q, rest_.data(), 0.0);
    for (std::size_t i = 0; i < bodies_.size(); ++i) poses[i] = frame_of(i);
  }

  Energy do_energy(const double* q, const double* v) override {
    tree_motion(robot(), coms_, q, v, motion_);
    Energy energy;
    for (std::size_t i = 0; i < motion_.size(); ++i) {
      const BodyMotion& body = motion_[i];
      const Eigen::Vector3d omega = body.rotation.transpose() * body.omega;
      energy.kinetic +=
          0.5 * inertials_[i].mass * body.com_rate.squaredNorm() + 0.5 * omega.dot(inertials_[i].inertia * omega);
      energy.potential -= inertials_[i].mass * gravity_.dot(body.com);
    }
    return energy;
  }

  // A run of ODE seen in joint coordinates. The velocity of step n was found in the configuration of step n - 1, which
  // is q - h v, and is handed on as it is. Where ODE would let the joints drift apart and pull them back (ERP), they
  // are put together exactly.
  void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) override {
    const bool quick = integrator == "quickstep";
    if (!quick && integrator != "step") {
      throw std::invalid_argument("ode: integrator " + quoted(integrator) + ", expected step or quickstep");
    }
    if (!usable(q, dof()) || !usable(v, dof()) || !usable(tau, dof())) {
      not_a_number(q);
      return not_a_number(v);
    }
    place(q, v, 0.0);
    carry_over_velocities(q, v, step);
    apply_efforts(tau);
    advance(quick, step);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      v[i] = joint_rate(i);
      q[i] += step * v[i];
    }
  }

  // As an ODE program runs it: bodies only, their joints kept by ERP alone.
  std::optional<JointGap> do_native_joint_gap(const double* q, const double* v, double step, int steps,
                                              double correction) override {
    if (!usable(q, dof()) || !usable(v, dof())) return JointGap{nan, nan};
    place(q, v, 0.0);
    dWorldSetERP(world_->id(), correction);
    for (int k = 0; k < steps; ++k) advance(false, step);
    dWorldSetERP(world_->id(), 0.0);
    JointGap worst;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const JointGap gap = gap_at(i);
      worst.distance = std::max(worst.distance, gap.distance);
      worst.angle = std::max(worst.angle, gap.angle);
    }
    return worst;
  }

 private:
  Eigen::Isometry3d frame_of(std::size_t body) const {
    const dReal* r = dBodyGetRotation(bodies_[body]);
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() << r[0], r[1], r[2], r[4], r[5], r[6], r[8], r[9], r[10];
    frame.translation() = from_ode(dBodyGetPosition(bodies_[body])) - frame.linear() * inertials_[body].com;
    return frame;
  }

  // Where the body is against where its joint lets it be.
  JointGap gap_at(std::size_t i) const {
    const Joint& joint = robot().joints()[i];
    const Eigen::Isometry3d parent =
        joint.parent < 0 ? Eigen::Isometry3d::Identity() : frame_of(static_cast<std::size_t>(joint.parent));
    const Eigen::Isometry3d moved = (parent * joint.origin).inverse() * frame_of(i);
    const Eigen::Vector3d off = moved.translation();
    if (joint.prismatic())
      return {(off - joint.axis * joint.axis.dot(off)).norm(), Eigen::AngleAxisd(moved.linear()).angle()};
    const Eigen::Vector3d turned = moved.linear() * joint.axis;
    return {off.norm(), std::atan2(turned.cross(joint.axis).norm(), turned.dot(joint.axis))};
  }

  void add_body(int index) {
    const Joint& joint = robot().joints()[index];
    const dBodyID body = dBodyCreate(world_->id());
    bodies_.push_back(body);
    coms_.emplace_back();
    write_mass(bodies_.size() - 1);
    const dBodyID parent = joint.parent < 0 ? nullptr : bodies_[joint.parent];
    const dJointID made =
        joint.prismatic() ? dJointCreateSlider(world_->id(), nullptr) : dJointCreateHinge(world_->id(), nullptr);
    dJointAttach(made, body, parent);
    joints_.push_back(made);
  }

  // An ODE body is its centre of mass: the frame lies there, parallel to ours.
  void write_mass(std::size_t body) {
    const Eigen::Matrix3d inertia = with_least_inertia(inertials_[body], least_inertia);
    dMass mass;
    dMassSetParameters(&mass, inertials_[body].mass, 0, 0, 0, inertia(0, 0), inertia(1, 1), inertia(2, 2),
                       inertia(0, 1), inertia(0, 2), inertia(1, 2));
    dBodySetMass(bodies_[body], &mass);
    coms_[body] = inertials_[body].com;
  }

  // ODE stores anchors relative to the centres of mass, so they are set anew whenever one of these moves.
  void anchor_joints() {
    place(rest_.data(), rest_.data(), 0.0);
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const Eigen::Vector3d& axis = motion_[i].axis;
      const Eigen::Vector3d& anchor = motion_[i].origin;
      if (robot().joints()[i].prismatic()) {
        dJointSetSliderAxis(joints_[i], axis.x(), axis.y(), axis.z());
      } else {
        dJointSetHingeAnchor(joints_[i], anchor.x(), anchor.y(), anchor.z());
        dJointSetHingeAxis(joints_[i], axis.x(), axis.y(), axis.z());
      }
    }
  }

  // Puts the bodies at q with the velocities of (2): those of v less `lag` seconds of their drift.
  void place(const double* q, const double* v, double lag) {
    tree_motion(robot(), coms_, q, v, motion_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const BodyMotion& body = motion_[i];
      dMatrix3 rotation;
      to_ode(body.rotation, rotation);
      dBodySetPosition(bodies_[i], body.com.x(), body.com.y(), body.com.z());
      dBodySetRotation(bodies_[i], rotation);
      set_velocity(i, body.com_rate - lag * body.com_drift, body.omega - lag * body.alpha_drift);
    }
  }
  void set_velocity(std::size_t body, const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) {
    dBodySetLinearVel(bodies_[body], linear.x(), linear.y(), linear.z());
    dBodySetAngularVel(bodies_[body], angular.x(), angular.y(), angular.z());
  }

  void carry_over_velocities(const double* q, const double* v, double step) {
    std::vector<double> before(q, q + dof());
    for (std::size_t i = 0; i < before.size(); ++i) before[i] -= step * v[i];
    std::vector<BodyMotion> earlier;
    tree_motion(robot(), coms_, before.data(), v, earlier);
    for (std::size_t i = 0; i < bodies_.size(); ++i) set_velocity(i, earlier[i].com_rate, earlier[i].omega);
  }

  // Both calls apply the opposite to the parent: a generalised force acts between the two bodies.
  void apply_efforts(const double* tau) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (robot().joints()[i].prismatic()) {
        dJointAddSliderForce(joints_[i], tau[i]);
      } else {
        dJointAddHingeTorque(joints_[i], tau[i]);
      }
    }
  }

  void apply_gyroscopic_torques() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const BodyMotion& body = motion_[i];
      const Eigen::Vector3d spin = inertials_[i].inertia * (body.rotation.transpose() * body.omega);
      const Eigen::Vector3d torque = -body.omega.cross(body.rotation * spin);
      dBodySetGyroscopicMode(bodies_[i], 0);
      dBodyAddTorque(bodies_[i], torque.x(), torque.y(), torque.z());
    }
  }

  void advance(bool quick, double step) {
    for (const dBodyID body : bodies_) dBodySetGyroscopicMode(body, 1);
    if (!quick) {
      dWorldStep(world_->id(), step);
      return;
    }
    // QuickStep shuffles its rows by ODE's one global random state: one thread at a time, from the same seed.
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    dRandSetSeed(1);
    dWorldQuickStep(world_->id(), step);
  }

  // u of (1): the bodies' velocities after the step, read as joint motion in the configuration before it.
  double joint_rate(std::size_t i) const {
    const Joint& joint = robot().joints()[i];
    const bool on_world = joint.parent < 0;
    const std::size_t parent = on_world ? i : static_cast<std::size_t>(joint.parent);
    const Eigen::Vector3d still = Eigen::Vector3d::Zero();
    const Eigen::Vector3d parent_omega = on_world ? still : from_ode(dBodyGetAngularVel(bodies_[parent]));
    if (!joint.prismatic()) return motion_[i].axis.dot(from_ode(dBodyGetAngularVel(bodies_[i])) - parent_omega);
    const Eigen::Vector3d parent_rate = on_world ? still : from_ode(dBodyGetLinearVel(bodies_[parent]));
    const Eigen::Vector3d carried = parent_rate + parent_omega.cross(motion_[i].com - motion_[parent].com);
    return motion_[i].axis.dot(from_ode(dBodyGetLinearVel(bodies_[i])) - carried);
  }

  void not_a_number(double* out) const { std::fill_n(out, dof(), std::numeric_limits<double>::quiet_NaN()); }

  std::shared_ptr<const Robot> shared_;
  std::vector<Inertial> inertials_;
  std::vector<Eigen::Vector3d> coms_;
  std::vector<double> rest_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  std::unique_ptr<World> world_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> joints_;
  std::vector<BodyMotion> motion_;  // of the last place()
};

class OdeEngine final : public Engine {
 public:
  EngineInfo info() const override {
    EngineInfo info;
    info.name = "ode";
    info.version = dODE_VERSION;
    info.available = true;
    info.capabilities = {
        {"forward_dynamics", false,
         "ODE steps bodies only: (v1 - v0)/h of one dWorldStep, corrected so that no step error is left"},
        {"inverse_dynamics", false, "mass matrix times the acceleration that is missing from forward dynamics"},
        {"mass_matrix", false, "inverted from dof + 1 forward dynamics"},
        {"inertials_in_place", true, "dBodySetMass, and the joints anchored anew"},
        {"gravity_in_place", true, "nothing is rebuilt"},
        {"point_masses", false, "a missing principal inertia is raised to 1e-8 of the body's own about its frame"},
    };
    info.own_models = {
        {"joint damping", "none at joints; bodies lose a share of their speeds a step (dWorldSetDamping), 0 here"},
        {"friction loss", "a motor of speed 0 and bounded effort, one more row of the LCP; none is set"},
        {"joint limits", "stops as rows of the LCP with ERP, CFM and bounce; none is set"},
        {"armature", "none"},
    };
    info.native_integrators = {"step", "quickstep"};
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const override {
    std::vector<Inertial> inertials;
    inertials.reserve(robot->dof());
    for (int i = 0; i < robot->dof(); ++i) inertials.push_back(robot->body_inertial(i));
    return std::make_unique<OdeDynamics>(std::move(robot), gravity, std::move(inertials));
  }
};

}  // namespace

const Engine& ode_engine() {
  static const OdeEngine engine;
  return engine;
}

}  // namespace lacuna
