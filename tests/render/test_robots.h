// Robots and poses for the tests of pictures, with forward kinematics of their own: no engine is needed.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "scenarios/robot.h"
#include "tests/scenarios/mesh_writer.h"

namespace lacuna::test {

/// A red box of 0.2 m on a slide along y at the origin.
inline const char* kRedBox = R"(<robot name="red_box">
  <link name="rail"/>
  <link name="box">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><box size=".2 .2 .2"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>
  </link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="box"/><axis xyz="0 1 0"/>
    <limit lower="-.05" upper=".05" effort="1" velocity="1"/></joint>
</robot>)";

/// An arm of three joints: a box on a turntable, a cylinder, and a last link without visuals.
inline const char* kArm = R"(<robot name="arm">
  <link name="base"/>
  <link name="turret">
    <inertial><origin xyz="0 0 .1"/><mass value="3"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial>
    <visual><origin xyz="0 0 .1"/><geometry><box size=".2 .15 .2"/></geometry>
      <material name="grey"><color rgba=".3 .3 .35 1"/></material></visual>
  </link>
  <link name="boom">
    <inertial><origin xyz=".3 0 0"/><mass value="2"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial>
    <visual><origin xyz=".3 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius=".05" length=".6"/></geometry>
      <material name="orange"><color rgba=".9 .5 .1 1"/></material></visual>
  </link>
  <link name="tip">
    <inertial><origin xyz=".2 0 0"/><mass value="1"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial>
  </link>
  <joint name="swing" type="revolute"><parent link="base"/><child link="turret"/><origin xyz="0 0 .1"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="lift" type="revolute"><parent link="turret"/><child link="boom"/><origin xyz="0 0 .2"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="wrist" type="continuous"><parent link="boom"/><child link="tip"/><origin xyz=".6 0 0"/><axis xyz="0 -1 0"/></joint>
</robot>)";

inline std::shared_ptr<const Robot> robot(const char* urdf) { return Robot::from_urdf_text(urdf, "test"); }

/// The robot with the mesh in place of the first visual of every link that has one.
inline std::shared_ptr<const Robot> with_mesh(const Robot& plain, const Mesh& mesh) {
  auto links = plain.links();
  for (Link& link : links) {
    if (link.visuals.empty()) continue;
    Visual& visual = link.visuals.front();
    visual.shape = Visual::Shape::mesh;
    visual.size.setZero();
    visual.mesh_file = "made.stl";
    visual.mesh = std::make_shared<const Mesh>(mesh);
  }
  return std::make_shared<const Robot>(plain.name(), plain.joints(), links, "test");
}

inline std::vector<Eigen::Isometry3d> link_poses(const Robot& robot, const std::vector<double>& q) {
  std::vector<Eigen::Isometry3d> bodies;
  for (int i = 0; i < robot.dof(); ++i) {
    const Joint& joint = robot.joints()[i];
    Eigen::Isometry3d pose = joint.parent < 0 ? joint.origin : bodies[joint.parent] * joint.origin;
    const double value = q.at(static_cast<std::size_t>(i));
    if (joint.prismatic()) {
      pose.translate(joint.axis * value);
    } else {
      pose.rotate(Eigen::AngleAxisd(value, joint.axis));
    }
    bodies.push_back(pose);
  }
  return robot.link_poses(bodies);
}

}  // namespace lacuna::test
