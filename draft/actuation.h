// What moves the joints, as far as the recordings show it: an actuator model a joint and start values for a search.
//
// Efforts are what the robot's own masses need for the measured motion (inverse dynamics, everything low-passed alike);
// models are linear in their parameters then, and ordinary least squares gives these.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna {

/// One recording in SI units, [joint][sample]; empty: not recorded. NaN where a sample is missing.
struct JointSignals {
  std::vector<double> time;  ///< s
  std::vector<std::vector<double>> position, velocity, command, effort;
};

/// How fast the recorded motion is, and where a low-pass may cut.
struct MotionBand {
  double rate = 0.0;       ///< Hz, of the samples
  double frequency = 0.0;  ///< Hz, rms acceleration over 2 pi rms speed, of the fastest joint
  double middle = 0.0;     ///< Hz, the same of the joint in the middle
  double cutoff_hz = 0.0;  ///< twenty times the fastest joint's, at most a fifth of the rate
};

struct ActuatorGuess {
  int joint = -1;
  std::string model;  ///< "torque_source", "flow_source", "direct_effort"; empty: nothing drives it
  double gain = 1.0;  ///< effort (flow_source: speed) per command
  double damping = 0.0, stiffness = 0.0, rest = 0.0;
  double neutral = 0.0;       ///< command at which the joint stands still (flow_source)
  double effort_scale = 1.0;  ///< of a motor's current: N m/A (N/A)
  std::string reason;
  bool sure = false;   ///< the recordings show it clearly
  bool holds = false;  ///< a spring brings it back: a long simulation does not drift
};

/// What the names of the columns say of each joint beforehand.
struct DriveHint {
  bool commanded = false;  ///< a command is recorded
  bool command_is_effort = false;
  bool effort_measured = false, effort_is_current = false;
};

struct ActuationGuess {
  MotionBand band;
  std::vector<ActuatorGuess> joints;  ///< one a joint of the robot
};

/// `gravity` m/s^2, world frame. Recordings of fewer than 20 samples are left out; where none is left, or a joint does
/// not move, its values are guesses from the robot's masses and limits, and said to be.
ActuationGuess guess_actuation(const std::shared_ptr<const Robot>& robot, const Eigen::Vector3d& gravity,
                               const std::vector<JointSignals>& recordings, const std::vector<DriveHint>& hints);

}  // namespace lacuna
