// URDF text of a robot, for other tools and for reading back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "scenarios/scenario.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

std::string triple(const Eigen::Vector3d& v) {
  // Adding 0 turns -0 into 0.
  return format_number(v[0] + 0.0) + ' ' + format_number(v[1] + 0.0) + ' ' + format_number(v[2] + 0.0);
}

/// Fixed-axis roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d to_rpy(const Eigen::Matrix3d& r) {
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
  if (std::hypot(r(0, 0), r(1, 0)) < 1e-12) return {std::atan2(-r(1, 2), r(1, 1)), pitch, 0.0};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

std::string origin(const Eigen::Isometry3d& pose) {
  if (pose.isApprox(Eigen::Isometry3d::Identity(), 0.0)) return "";
  const bool turned = !pose.linear().isApprox(Eigen::Matrix3d::Identity(), 0.0);
  return fmt::format("<origin xyz='{}'{}/>", triple(pose.translation()),
                     turned ? fmt::format(" rpy='{}'", triple(to_rpy(pose.linear()))) : "");
}

std::string visual_text(const Visual& visual, const std::string& material) {
  std::string shape;
  switch (visual.shape) {
    case Visual::Shape::box: shape = fmt::format("<box size='{}'/>", triple(visual.size)); break;
    case Visual::Shape::cylinder:
      shape = fmt::format("<cylinder radius='{}' length='{}'/>", format_number(visual.size[0]),
                          format_number(visual.size[1]));
      break;
    case Visual::Shape::sphere: shape = fmt::format("<sphere radius='{}'/>", format_number(visual.size[0])); break;
    case Visual::Shape::mesh:
      shape = fmt::format("<mesh filename='{}' scale='{}'/>", xml_escaped(visual.mesh_file), triple(visual.mesh_scale));
      break;
  }
  const auto& c = visual.rgba;
  return fmt::format(
      "    <visual>{}<geometry>{}</geometry><material name='{}'><color rgba='{} {} {} {}'/></material></visual>\n",
      origin(visual.pose), shape, xml_escaped(material), c[0], c[1], c[2], c[3]);
}

std::string link_text(const Link& link, double mass) {
  std::string body;
  if (mass > 0.0) {
    // A link that had no mass becomes a point mass at its centre.
    const Inertial inertial =
        link.inertial.mass > 0.0 ? link.inertial.scaled(mass / link.inertial.mass) : link.inertial;
    const Eigen::Matrix3d& i = inertial.inertia;
    body += fmt::format(
        "    <inertial><origin xyz='{}'/><mass value='{}'/>"
        "<inertia ixx='{}' ixy='{}' ixz='{}' iyy='{}' iyz='{}' izz='{}'/></inertial>\n",
        triple(inertial.com), format_number(mass), format_number(i(0, 0)), format_number(i(0, 1)),
        format_number(i(0, 2)), format_number(i(1, 1)), format_number(i(1, 2)), format_number(i(2, 2)));
  }
  for (std::size_t v = 0; v < link.visuals.size(); ++v)
    body += visual_text(link.visuals[v], fmt::format("{}_{}", link.name, v));
  const std::string name = xml_escaped(link.name);
  return body.empty() ? fmt::format("  <link name='{}'/>\n", name)
                      : fmt::format("  <link name='{}'>\n{}  </link>\n", name, body);
}

std::string ends(const std::string& parent, const std::string& child) {
  return fmt::format("<parent link='{}'/><child link='{}'/>", xml_escaped(parent), xml_escaped(child));
}

std::string joint_text(const Joint& joint, const std::string& parent, const std::string& child) {
  static constexpr const char* kTypes[] = {"revolute", "continuous", "prismatic"};
  std::string limit;
  // URDF has no infinity: the largest number stands for "unlimited" and reads back as a limit never reached.
  const auto bounded = [](double v) { return format_number(std::clamp(v, -1e300, 1e300)); };
  if (joint.type != JointType::continuous)
    limit = fmt::format("<limit lower='{}' upper='{}' effort='{}' velocity='{}'/>", bounded(joint.lower),
                        bounded(joint.upper), bounded(joint.effort), bounded(joint.velocity));
  else if (std::isfinite(joint.effort) || std::isfinite(joint.velocity))
    limit = fmt::format("<limit effort='{}' velocity='{}'/>", bounded(joint.effort), bounded(joint.velocity));
  return fmt::format("  <joint name='{}' type='{}'>{}{}<axis xyz='{}'/>{}</joint>\n", xml_escaped(joint.name),
                     kTypes[static_cast<int>(joint.type)], ends(parent, child), origin(joint.origin),
                     triple(joint.axis), limit);
}

/// A name that no other joint or link has yet.
std::string unused(std::string name, std::set<std::string>& taken) {
  while (!taken.insert(name).second) name += '_';
  return name;
}

}  // namespace

std::string to_urdf(const Robot& robot, std::span<const double> link_masses) {
  const auto& links = robot.links();
  if (!link_masses.empty() && link_masses.size() != links.size())
    throw std::invalid_argument(fmt::format("{} link masses for {} links", link_masses.size(), links.size()));
  std::set<std::string> taken;
  for (const Joint& joint : robot.joints()) taken.insert(joint.name);
  for (const Link& link : links) taken.insert(link.name);

  std::string out = fmt::format("<?xml version='1.0'?>\n<robot name='{}'>\n", xml_escaped(robot.name()));
  const auto is_root = [](const Link& l) {
    return l.body < 0 && l.in_body.isApprox(Eigen::Isometry3d::Identity(), 0.0);
  };
  const auto root = std::find_if(links.begin(), links.end(), is_root);
  const std::string world = root == links.end() ? unused("world", taken) : root->name;
  if (root == links.end()) out += fmt::format("  <link name='{}'/>\n", world);
  for (std::size_t i = 0; i < links.size(); ++i)
    out += link_text(links[i], link_masses.empty() ? links[i].inertial.mass : link_masses[i]);

  const auto carrier = [&](int body) {
    return body < 0 ? world : links[static_cast<std::size_t>(robot.joints()[static_cast<std::size_t>(body)].link)].name;
  };
  for (int i = 0; i < robot.dof(); ++i) {
    const Joint& joint = robot.joints()[static_cast<std::size_t>(i)];
    out += joint_text(joint, carrier(joint.parent), carrier(i));
  }
  for (const Link& link : links) {
    if (link.name == carrier(link.body)) continue;
    out +=
        fmt::format("  <joint name='{}' type='fixed'>{}{}</joint>\n", xml_escaped(unused(link.name + "_mount", taken)),
                    ends(carrier(link.body), link.name), origin(link.in_body));
  }
  return out + "</robot>\n";
}

}  // namespace lacuna
