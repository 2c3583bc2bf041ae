// Where the bodies of a robot are and how they move, in maximal coordinates, from joint coordinates.
//
// ODE knows six coordinates a body and no joint angle, so this is the bridge to it and back.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna {

/// One body; everything in world axes.
struct BodyMotion {
  Eigen::Matrix3d rotation;     ///< body axes in the world
  Eigen::Vector3d origin;       ///< m, of the body frame, which lies on the joint axis
  Eigen::Vector3d axis;         ///< unit vector of the body's own joint
  Eigen::Vector3d com;          ///< m
  Eigen::Vector3d omega;        ///< rad/s
  Eigen::Vector3d com_rate;     ///< m/s
  Eigen::Vector3d alpha_drift;  ///< rad/s^2, angular acceleration at zero joint accelerations: (dS/dt v)
  Eigen::Vector3d com_drift;    ///< m/s^2, of the centre of mass at zero joint accelerations
};

/// Forward kinematics of every body at (q, v); `coms` are centres of mass in the body frames (m).
void tree_motion(const Robot& robot, const std::vector<Eigen::Vector3d>& coms, const double* q, const double* v,
                 std::vector<BodyMotion>& motion);

}  // namespace lacuna
