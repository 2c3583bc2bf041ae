// Where the kernels put the bodies' frames, chosen once from the robot so that most of the arithmetic falls away.
//
// Each joint's axis is its body's local z (after J. Denavit, R. S. Hartenberg, J. Applied Mechanics 22 (1955), in the
// form of J. J. Craig, Introduction to Robotics, 1986, ch. 3). The way from a parent's frame to its child's is
//   turn about z (swing) -> turn about x (tilt) -> shift -> turn about or slide along z by the joint.
// A frame's x lies along the common normal of its own axis and its first child's, and its origin where that normal
// meets the axis, so that on a chain there is no swing, the tilt is mostly nothing or a quarter turn, and the shift has
// one or two coordinates. Nothing is approximated: nearly parallel axes just keep a general shift.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna {

/// Turn about x by the angle between two axes.
enum class Tilt { none, quarter, any };

struct Mount {
  int parent = -1;
  bool prismatic = false;
  Eigen::Matrix3d align = Eigen::Matrix3d::Identity();    ///< URDF body frame <- kernel frame
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();       ///< m, kernel origin in the URDF body frame
  Eigen::Matrix3d to_rest = Eigen::Matrix3d::Identity();  ///< rest frame <- parent's kernel frame (roots: <- world)

  // The same turn in parts; not used for roots. The rest frame is the body's at q = 0, turned back by `offset`.
  bool swings = false;
  double cos_swing = 1.0, sin_swing = 0.0;
  Tilt tilt = Tilt::none;
  double cos_tilt = 1.0, sin_tilt = 0.0;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< m, from the parent's kernel origin to ours, rest frame
  bool shifts = false;                              ///< the joint slides, or its origin lies off the parent's
  double offset = 0.0;                              ///< rad, about z: added to q, or where it slides the turn itself
};

/// One mount per joint, in the robot's order.
std::vector<Mount> mounts_of(const Robot& robot);

}  // namespace lacuna
