// A robot and its plain model from MuJoCo's MJCF, read by a bounded reader of our own: no other file is ever opened.
//
// Bodies, hinges and slides, inertials (or geoms of simple shape), damping, springs, dry friction, armature and simple
// actuators become the plain model; defaults with their classes, angles in degrees and every way to write an
// orientation are understood. What moves the machine and is not understood is refused by name: includes, ball and free
// joints, several joints in one body, equality constraints, tendons. What only other tools need (cameras, sensors,
// contacts) is left out, with a note where it matters. Source: MuJoCo documentation, "XML Reference".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/robot.h"
#include "scenarios/scenario.h"

namespace lacuna {

struct MjcfModel {
  std::shared_ptr<const Robot> robot;
  std::vector<ActuatorSpec> actuators;  ///< torque_source where a spring acts, else direct_effort; `damping` in both
  std::vector<EffectSpec> effects;      ///< armature, coulomb_friction, valve_offset, actuator_lag
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< m/s^2, world frame
};

/// Throws InputError with file and line. `notes` receives what was left out.
MjcfModel read_mjcf_text(const std::string& xml, const std::string& source, std::vector<std::string>* notes = nullptr);

/// A robot's file by what it holds: URDF, or MJCF (root element `mujoco`), whose model then fills actuators and
/// effects. At most 16 MiB. A xacro file is refused with the command that makes a URDF of it. Throws InputError.
MjcfModel read_robot_file(const std::filesystem::path& file, std::vector<std::string>* notes = nullptr);

}  // namespace lacuna
