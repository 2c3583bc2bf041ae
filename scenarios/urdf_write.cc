#include "scenarios/urdf_write.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "scenarios/scenario.h"
#include "scenarios/xml_writer.h"

namespace lacuna {
namespace {

/// Fixed-axis roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d to_rpy(const Eigen::Matrix3d& r) {
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
  if (std::hypot(r(0, 0), r(1, 0)) < 1e-12) return {std::atan2(-r(1, 2), r(1, 1)), pitch, 0.0};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

void put_origin(XmlWriter& xml, const Eigen::Isometry3d& pose) {
  if (pose.isApprox(Eigen::Isometry3d::Identity(), 0.0)) return;
  xml.open("origin").set("xyz", pose.translation());
  if (!pose.linear().isApprox(Eigen::Matrix3d::Identity(), 0.0)) xml.set("rpy", to_rpy(pose.linear()));
  xml.close();
}

void put_shape(XmlWriter& xml, const Visual& visual) {
  switch (visual.shape) {
    case Visual::Shape::box: xml.open("box").set("size", visual.size); break;
    case Visual::Shape::cylinder:
      xml.open("cylinder").set("radius", visual.size[0]).set("length", visual.size[1]);
      break;
    case Visual::Shape::sphere: xml.open("sphere").set("radius", visual.size[0]); break;
    case Visual::Shape::mesh: xml.open("mesh").set("filename", visual.mesh_file).set("scale", visual.mesh_scale); break;
  }
  xml.close();
}

void put_visual(XmlWriter& xml, const Visual& visual, const std::string& material) {
  xml.line("visual");
  put_origin(xml, visual.pose);
  xml.open("geometry");
  put_shape(xml, visual);
  xml.close().open("material").set("name", material);
  xml.open("color").set("rgba", fmt::format("{}", fmt::join(visual.rgba, " "))).close().close().close();
}

void put_inertial(XmlWriter& xml, const Inertial& inertial) {
  const Eigen::Matrix3d& i = inertial.inertia;
  xml.line("inertial").open("origin").set("xyz", inertial.com).close();
  xml.open("mass").set("value", inertial.mass).close();
  xml.open("inertia").set("ixx", i(0, 0)).set("ixy", i(0, 1)).set("ixz", i(0, 2));
  xml.set("iyy", i(1, 1)).set("iyz", i(1, 2)).set("izz", i(2, 2)).close().close();
}

void put_link(XmlWriter& xml, const Link& link, double mass) {
  xml.open("link").set("name", link.name);
  if (mass > 0.0) {
    // A link that had no mass becomes a point mass at its centre.
    Inertial inertial = link.inertial.mass > 0.0 ? link.inertial.scaled(mass / link.inertial.mass) : link.inertial;
    inertial.mass = mass;
    put_inertial(xml, inertial);
  }
  for (std::size_t v = 0; v < link.visuals.size(); ++v)
    put_visual(xml, link.visuals[v], fmt::format("{}_{}", link.name, v));
  xml.close();
}

/// Begins a joint; the caller ends it.
void begin_joint(XmlWriter& xml, const std::string& name, const char* type, const std::string& parent,
                 const std::string& child, const Eigen::Isometry3d& origin) {
  xml.line("joint").set("name", name).set("type", type);
  xml.open("parent").set("link", parent).close().open("child").set("link", child).close();
  put_origin(xml, origin);
}

void put_joint(XmlWriter& xml, const Joint& joint, const std::string& parent, const std::string& child) {
  static constexpr const char* kTypes[] = {"revolute", "continuous", "prismatic"};
  // URDF has no infinity: the largest number stands for "unlimited" and reads back as a limit never reached.
  const auto bounded = [](double v) { return std::clamp(v, -1e300, 1e300); };
  begin_joint(xml, joint.name, kTypes[static_cast<int>(joint.type)], parent, child, joint.origin);
  xml.open("axis").set("xyz", joint.axis).close();
  const bool turns_freely = joint.type == JointType::continuous;
  if (!turns_freely || std::isfinite(joint.effort) || std::isfinite(joint.velocity)) {
    xml.open("limit");
    if (!turns_freely) xml.set("lower", bounded(joint.lower)).set("upper", bounded(joint.upper));
    xml.set("effort", bounded(joint.effort)).set("velocity", bounded(joint.velocity)).close();
  }
  xml.close();
}

/// A name that no other joint or link has yet.
std::string unused(std::string name, std::set<std::string>& taken) {
  while (!taken.insert(name).second) name += '_';
  return name;
}

}  // namespace

std::string to_urdf(const Robot& robot, std::span<const double> link_masses) {
  return commented_urdf(robot, link_masses, {});
}

std::string commented_urdf(const Robot& robot, std::span<const double> link_masses,
                           std::span<const std::string> comments) {
  const auto& links = robot.links();
  if (!link_masses.empty() && link_masses.size() != links.size())
    throw std::invalid_argument(fmt::format("{} link masses for {} links", link_masses.size(), links.size()));
  std::set<std::string> taken;
  for (const Joint& joint : robot.joints()) taken.insert(joint.name);
  for (const Link& link : links) taken.insert(link.name);

  XmlWriter xml;
  xml.declare();
  for (const std::string& comment : comments) xml.comment(comment);
  xml.open("robot").set("name", robot.name());
  const auto is_root = [](const Link& l) {
    return l.body < 0 && l.in_body.isApprox(Eigen::Isometry3d::Identity(), 0.0);
  };
  const auto root = std::find_if(links.begin(), links.end(), is_root);
  const std::string world = root == links.end() ? unused("world", taken) : root->name;
  if (root == links.end()) xml.open("link").set("name", world).close();
  for (std::size_t i = 0; i < links.size(); ++i)
    put_link(xml, links[i], link_masses.empty() ? links[i].inertial.mass : link_masses[i]);

  const auto carrier = [&](int body) { return body < 0 ? world : links[robot.joints()[body].link].name; };
  for (int i = 0; i < robot.dof(); ++i) {
    const Joint& joint = robot.joints()[i];
    put_joint(xml, joint, carrier(joint.parent), carrier(i));
  }
  for (const Link& link : links) {
    if (link.name == carrier(link.body)) continue;
    begin_joint(xml, unused(link.name + "_mount", taken), "fixed", carrier(link.body), link.name, link.in_body);
    xml.close();
  }
  return xml.close().str();
}

}  // namespace lacuna
