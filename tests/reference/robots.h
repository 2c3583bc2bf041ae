// Robots made in a line or two, for tests.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna::test {

/// One moving body, its link frame being the body frame.
struct BodySpec {
  int parent = -1;
  JointType type = JointType::revolute;
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Inertial inertial;
};

inline std::shared_ptr<const Robot> make_robot(const std::string& name, const std::vector<BodySpec>& bodies) {
  std::vector<Joint> joints;
  std::vector<Link> links;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Joint joint;
    joint.name = "joint_" + std::to_string(i);
    joint.type = bodies[i].type;
    joint.parent = bodies[i].parent;
    joint.link = static_cast<int>(i);
    joint.origin = bodies[i].origin;
    joint.axis = bodies[i].axis;
    joints.push_back(joint);
    Link link;
    link.name = "link_" + std::to_string(i);
    link.body = static_cast<int>(i);
    link.inertial = bodies[i].inertial;
    links.push_back(link);
  }
  return std::make_shared<const Robot>(name, std::move(joints), std::move(links), name);
}

inline Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, y, z)); }

}  // namespace lacuna::test
