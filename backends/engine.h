// The one interface to rigid-body dynamics. An engine is an acceleration oracle first: (q, v, tau) -> a.
//
// Everything that is not rigid-body (actuators, friction, delay, sensors) is physics/, written once above this line.
// Conventions: joint i moves body i (scenarios/robot.h); q in rad or m, v its rate, tau generalised force (N m or N);
// poses and gravity in the world frame; the base is fixed to the world. Joint limits, damping, contacts and friction
// losses of the engine itself are off, but for set_own_losses.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna {

struct Energy {
  double kinetic = 0.0;    ///< J
  double potential = 0.0;  ///< J, zero with every centre of mass at the world origin
  double total() const { return kinetic + potential; }
};

/// How far a joint's two bodies have come apart.
struct JointGap {
  double distance = 0.0;  ///< m, between their ideas of where the joint is
  double angle = 0.0;     ///< rad, between their ideas of its axis (a slide: of its orientation)
};

/// What an engine can do itself, and how the rest is made up for, in words for `lacuna engines`.
struct Capability {
  std::string name;     ///< "inverse_dynamics", "mass_matrix", "inertials_in_place", "gravity_in_place", ...
  bool native = false;  ///< false: derived here, as `words` say
  std::string words;
};

/// What an engine would model itself beside rigid bodies. It is always off here: physics/ does it, the same for all.
struct OwnModel {
  std::string quantity;  ///< "joint damping", "friction loss", "joint limits", "armature"
  std::string words;     ///< how the engine models it, and how it is switched off
};

/// What a joint loses by the engine's own model.
struct JointLoss {
  double damping = 0.0;   ///< N m s/rad (N s/m), 0 or above
  double friction = 0.0;  ///< N m (N), bound of dry friction, 0 or above
};

struct EngineInfo {
  std::string name;     ///< as its folder: "featherstone", "mujoco", ...
  std::string version;  ///< of the library, "" where it is not built
  bool available = false;
  std::string reason;  ///< why it is not available
  std::vector<Capability> capabilities;
  std::vector<std::string> native_integrators;  ///< names that native_step takes, the engine's default first
  std::vector<OwnModel> own_models;
  bool own_losses = false;  ///< Dynamics::set_own_losses works
};

/// One robot built in one engine, with its scratch state. Not shared between threads: give each its clone().
///
/// Public calls check their arguments (sizes, throws std::invalid_argument) and count on nothing else;
/// engines implement the protected `do_` part. Results depend only on the arguments and the parameters set,
/// never on earlier calls.
class Dynamics {
 public:
  virtual ~Dynamics() = default;
  Dynamics& operator=(const Dynamics&) = delete;

  virtual std::unique_ptr<Dynamics> clone() const = 0;
  const Robot& robot() const { return *robot_; }
  int dof() const { return robot_->dof(); }

  /// Mass properties of body `body` in its own frame (mass > 0). Rebuilds only where the engine must.
  void set_inertial(int body, const Inertial& inertial);
  void set_gravity(const Eigen::Vector3d& gravity);  ///< m/s^2, world frame

  /// a(q, v, tau). Spans of dof() numbers.
  void forward_dynamics(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
                        std::span<double> a);
  /// tau(q, v, a), gravity included.
  void inverse_dynamics(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                        std::span<double> tau);
  /// Joint-space inertia, dof x dof, symmetric (kg m^2, kg, kg m).
  void mass_matrix(std::span<const double> q, Eigen::MatrixXd& mass);
  /// World pose of every body.
  void body_poses(std::span<const double> q, std::vector<Eigen::Isometry3d>& poses);
  Energy energy(std::span<const double> q, std::span<const double> v);

  /// One step of the engine's own integrator, tau held; q and v are advanced in place. `integrator` is one of
  /// EngineInfo::native_integrators (throws std::invalid_argument otherwise).
  void native_step(const std::string& integrator, std::span<double> q, std::span<double> v, std::span<const double> tau,
                   double step);

  /// From here on native_step, and it alone, also has these losses as the engine models them itself
  /// (EngineInfo::own_models); one a joint, or none at all: rigid bodies alone. Throws WorkError where the engine has
  /// no such model here.
  void set_own_losses(std::span<const JointLoss> losses);

  /// Largest gaps after `steps` of the engine's own steps from (q, v), no efforts, where its state is bodies and not
  /// joint coordinates; nothing where joints cannot come apart. `correction`: share of a gap that is pulled back a
  /// step.
  std::optional<JointGap> native_joint_gap(std::span<const double> q, std::span<const double> v, double step, int steps,
                                           double correction);

 protected:
  explicit Dynamics(std::shared_ptr<const Robot> robot) : robot_(std::move(robot)) {}
  Dynamics(const Dynamics&) = default;

  virtual void do_set_inertial(int body, const Inertial& inertial) = 0;
  virtual void do_set_gravity(const Eigen::Vector3d& gravity) = 0;
  virtual void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) = 0;
  /// Default: dof() + 1 forward dynamics at zero velocity give the inverse of the mass matrix.
  virtual void do_mass_matrix(const double* q, Eigen::MatrixXd& mass);
  /// Default: tau = M(q) (a - forward_dynamics(q, v, 0)).
  virtual void do_inverse_dynamics(const double* q, const double* v, const double* a, double* tau);
  virtual void do_body_poses(const double* q, std::vector<Eigen::Isometry3d>& poses) = 0;
  virtual Energy do_energy(const double* q, const double* v) = 0;
  virtual void do_native_step(const std::string& integrator, double* q, double* v, const double* tau, double step) = 0;
  /// Default: WorkError. One a joint, or empty.
  virtual void do_set_own_losses(std::span<const JointLoss> losses);
  virtual std::optional<JointGap> do_native_joint_gap(const double*, const double*, double, int, double) {
    return std::nullopt;
  }

 private:
  std::shared_ptr<const Robot> robot_;
};

/// An engine as a maker of Dynamics. One instance per engine lives in the registry.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  /// Throws WorkError with the reason where the engine is not available or cannot hold the robot.
  virtual std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot> robot, const Eigen::Vector3d& gravity) const = 0;
};

/// All engines, featherstone first, in a fixed order; missing ones are stubs that say why.
const std::vector<const Engine*>& engines();
/// Throws InputError listing the names for an unknown one.
const Engine& find_engine(const std::string& name);

}  // namespace lacuna
