#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "scenarios/generate/bundle.h"
#include "scenarios/urdf_write.h"

namespace lacuna::generate {
namespace {

using Eigen::Vector3d;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<float, 4> kDark{0.25f, 0.27f, 0.30f, 1.0f};
constexpr std::array<float, 4> kOrange{0.93f, 0.55f, 0.10f, 1.0f};
constexpr std::array<float, 4> kGrey{0.60f, 0.62f, 0.66f, 1.0f};

/// Six significant digits: what a table holds, and enough that no check can tell.
double rounded(double value) { return std::stod(fmt::format("{:.6g}", value)); }

Inertial uniform_box(double mass, const Vector3d& size, const Vector3d& centre) {
  const Vector3d s2 = size.cwiseProduct(size);
  Inertial out{mass, centre, Eigen::Matrix3d::Zero()};
  out.inertia.diagonal() << rounded(mass / 12 * (s2[1] + s2[2])), rounded(mass / 12 * (s2[0] + s2[2])),
      rounded(mass / 12 * (s2[0] + s2[1]));
  return out;
}

/// A tube along x.
Inertial uniform_tube(double mass, double outer, double inner, double length, const Vector3d& centre) {
  const double radii = outer * outer + inner * inner;
  Inertial out{mass, centre, Eigen::Matrix3d::Zero()};
  const double across = rounded(mass / 12 * (3 * radii + length * length));
  out.inertia.diagonal() << rounded(mass / 2 * radii), across, across;
  return out;
}

Link box_link(const std::string& name, int body, double mass, const Vector3d& size, const Vector3d& centre,
              const std::array<float, 4>& rgba) {
  Link link{name, body, Eigen::Isometry3d::Identity(), uniform_box(mass, size, centre), {}};
  Visual visual;
  visual.size = size;
  visual.pose.translation() = centre;
  visual.rgba = rgba;
  link.visuals.push_back(visual);
  return link;
}

Link tube_link(const std::string& name, int body, double mass, double outer, double inner, double length,
               const Vector3d& centre, const std::array<float, 4>& rgba) {
  Link link{name, body, Eigen::Isometry3d::Identity(), uniform_tube(mass, outer, inner, length, centre), {}};
  Visual visual;
  visual.shape = Visual::Shape::cylinder;
  visual.size = {outer, length, 0.0};
  visual.pose.translation() = centre;
  visual.pose.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
  visual.rgba = rgba;
  link.visuals.push_back(visual);
  return link;
}

/// Joint `index` on the body before it; its child link is link index + 1, after the base.
Joint joint(const std::string& name, JointType type, int index, const Vector3d& origin, const Vector3d& axis) {
  Joint out;
  out.name = name;
  out.type = type;
  out.parent = index - 1;
  out.link = index + 1;
  out.origin.translation() = origin;
  out.axis = axis;
  return out;
}

Joint limited(Joint joint, double lower, double upper, double effort, double velocity) {
  joint.lower = lower;
  joint.upper = upper;
  joint.effort = effort;
  joint.velocity = velocity;
  return joint;
}

std::vector<Joint> arm_joints() {
  const Vector3d up(0, 0, 1), pitch(0, -1, 0), roll(1, 0, 0);
  const auto revolute = JointType::revolute;
  const auto deg = [](double angle) { return rounded(angle * kDegree); };
  Joint rotate = joint("joint_6", JointType::continuous, 5, {0.17, 0, 0}, roll);
  rotate.effort = 105;
  rotate.velocity = 1.5;
  return {limited(joint("joint_1", revolute, 0, {0, 0, 0.1}, up), deg(-60), deg(60), 527, 0.35),
          limited(joint("joint_2", revolute, 1, {0.07, 0, 0.06}, pitch), deg(-30), deg(90), 1532, 0.2),
          limited(joint("joint_3", revolute, 2, {0.5, 0, 0}, pitch), deg(-105), deg(10), 753, 0.3),
          limited(joint("joint_4", revolute, 3, {0.14, 0, -0.08}, roll), deg(-135), deg(135), 264, 0.6),
          limited(joint("joint_5", revolute, 4, {0.3, 0, 0}, pitch), deg(-55), deg(55), 306, 0.5),
          rotate};
}

/// Base and links 1 to 5; what follows differs between the robots.
std::vector<Link> arm_links(const LinkMasses& m) {
  Link base;
  base.name = "base";
  return {base,
          box_link("link_1", 0, m[0], {0.16, 0.14, 0.20}, {0.035, 0, 0.03}, kDark),
          box_link("link_2", 1, m[1], {0.56, 0.12, 0.12}, {0.25, 0, 0}, kOrange),
          box_link("link_3", 2, m[2], {0.26, 0.20, 0.18}, {0.11, 0, -0.05}, kOrange),
          tube_link("link_4", 3, m[3], 0.045, 0.0415, 0.30, {0.15, 0, 0}, kGrey),
          box_link("link_5", 4, m[4], {0.20, 0.10, 0.10}, {0.085, 0, 0}, kDark)};
}

Link tool_link() {
  Link tool;
  tool.name = "tool";
  tool.body = 5;
  tool.in_body.translation() = Vector3d(0.16, 0, 0);
  return tool;
}

/// A thin square rod of the given length that reaches from the link's origin to direction * length.
Link rod(const std::string& name, int body, double mass, double length, double direction,
         const std::array<float, 4>& rgba) {
  return box_link(name, body, mass, {0.02, 0.02, length}, {0, 0, direction * length / 2}, rgba);
}

}  // namespace

std::string commented_urdf(const Robot& robot, const std::string& comment) {
  const std::string text =
      comment + "\n     Written by lacuna_generate_scenarios; change scenarios/generate/robots.cc.";
  return lacuna::commented_urdf(robot, {}, std::span(&text, 1));
}

std::shared_ptr<const Robot> hydrolek() {
  constexpr double kJawMass = 0.6;
  auto links = arm_links(kTable1Masses);
  auto joints = arm_joints();
  // Link 6 ends where the jaw begins, and together they keep the mass and the centre (x = 0.09 m) of the seed's link 6:
  // (4.1 * 0.075 + 0.6 * 0.1925) / 4.7 = 0.09.
  links.push_back(
      box_link("link_6", 5, rounded(kTable1Masses[5] - kJawMass), {0.17, 0.12, 0.12}, {0.075, 0, 0}, kGrey));
  links.push_back(box_link("jaw", 6, kJawMass, {0.065, 0.03, 0.06}, {0.0325, 0, 0}, kDark));
  joints.push_back(limited(joint("joint_7", JointType::prismatic, 6, {0.16, 0, 0}, {0, 1, 0}), 0.0, 0.10, 1500, 0.1));
  links.push_back(tool_link());
  return std::make_shared<const Robot>("hydrolek", std::move(joints), std::move(links), "hydrolek");
}

std::shared_ptr<const Robot> seed_arm(const std::string& name, const LinkMasses& masses) {
  auto links = arm_links(masses);
  links.push_back(box_link("link_6", 5, masses[5], {0.20, 0.12, 0.12}, {0.09, 0, 0}, kGrey));
  links.push_back(tool_link());
  return std::make_shared<const Robot>(name, arm_joints(), std::move(links), name);
}

std::shared_ptr<const Robot> pendulum() {
  Link base;
  base.name = "base";
  std::vector<Joint> joints{joint("swing", JointType::continuous, 0, {0, 0, 1.5}, {0, -1, 0})};
  std::vector<Link> links{base, rod("rod", 0, 1.0, 1.0, -1.0, kOrange)};
  return std::make_shared<const Robot>("pendulum", std::move(joints), std::move(links), "pendulum");
}

std::shared_ptr<const Robot> double_pendulum() {
  Link base;
  base.name = "base";
  std::vector<Joint> joints{joint("shoulder", JointType::continuous, 0, {0, 0, 2.0}, {0, -1, 0}),
                            joint("elbow", JointType::continuous, 1, {0, 0, -1.0}, {0, -1, 0})};
  std::vector<Link> links{base, rod("upper", 0, 1.5, 1.0, -1.0, kOrange), rod("lower", 1, 0.8, 0.7, -1.0, kGrey)};
  return std::make_shared<const Robot>("double_pendulum", std::move(joints), std::move(links), "double_pendulum");
}

std::shared_ptr<const Robot> cartpole() {
  Link rail;
  rail.name = "rail";
  std::vector<Joint> joints{limited(joint("slide", JointType::prismatic, 0, {0, 0, 0.5}, {1, 0, 0}), -2.0, 2.0, 50, 5),
                            joint("pole", JointType::continuous, 1, {0, 0, 0}, {0, 1, 0})};
  std::vector<Link> links{rail, box_link("cart", 0, 1.2, {0.30, 0.16, 0.10}, {0, 0, 0}, kDark),
                          rod("pole_rod", 1, 0.3, 0.6, 1.0, kOrange)};
  return std::make_shared<const Robot>("cartpole", std::move(joints), std::move(links), "cartpole");
}

std::shared_ptr<const Robot> chain(int links) {
  const double length = 2.0 / links, width = 0.2 * length;
  Link base;
  base.name = "base";
  std::vector<Joint> joints;
  std::vector<Link> rods{base};
  for (int i = 0; i < links; ++i) {
    const Vector3d origin(0, 0, i == 0 ? 2.5 : -length), axis(i % 2, 1 - i % 2, 0);
    joints.push_back(joint(fmt::format("joint_{}", i + 1), JointType::continuous, i, origin, axis));
    rods.push_back(box_link(fmt::format("link_{}", i + 1), i, 4.0 / links, {width, width, length},
                            {0, 0, -0.5 * length}, i % 2 == 0 ? kOrange : kGrey));
  }
  const std::string name = fmt::format("chain_{}", links);
  return std::make_shared<const Robot>(name, std::move(joints), std::move(rods), name);
}

std::shared_ptr<const Robot> skew_arm() {
  auto links = arm_links(kTable1Masses);
  Link last = box_link("link_6", 5, kTable1Masses[5], {0.30, 0.06, 0.10}, {0.12, 0.04, -0.03}, kGrey);
  const Eigen::Matrix3d askew =
      (Eigen::AngleAxisd(0.6, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.4, Vector3d::UnitY())).toRotationMatrix();
  const Eigen::Matrix3d turned = askew * last.inertial.inertia * askew.transpose();
  last.inertial.inertia = turned.unaryExpr(&rounded);
  last.visuals.front().pose.linear() = askew;
  links.push_back(last);
  links.push_back(tool_link());
  return std::make_shared<const Robot>("skew_arm", arm_joints(), std::move(links), "skew_arm");
}

void add_robots(Files& files) {
  files["hydrolek/hydrolek.urdf"] = commented_urdf(
      *hydrolek(),
      "Seven-function hydraulic manipulator of the HydroLek HLK-7W class: six revolute joints and a gripper jaw.\n"
      "     Masses: Table 1 of the seed paper, the jaw's 0.6 kg taken out of link 6 (42.6 kg in all). Frames and "
      "inertias:\n"
      "     plausible geometry (uniform boxes, link 4 a tube). SI units.");
  const std::string seed = "The seed paper's six-joint arm, the gripper part of link 6. Masses: ";
  files["hydrolek/seed_start.urdf"] =
      commented_urdf(*seed_arm("seed_start", kInitialMasses), seed + "its row \"Init.\", where identification starts.");
  files["hydrolek/seed_table1.urdf"] =
      commented_urdf(*seed_arm("seed_table1", kTable1Masses), seed + "its Table 1 (42.6 kg in all).");
  files["hydrolek/seed_table5.urdf"] =
      commented_urdf(*seed_arm("seed_table5", kTable5Masses), seed + "its Table 5 (45.66 kg in all).");
  files["pendulum/pendulum.urdf"] =
      commented_urdf(*pendulum(), "A uniform rod of 1 kg and 1 m that hangs from a pivot; q = 0 hangs straight down.");
  files["double_pendulum/double_pendulum.urdf"] = commented_urdf(
      *double_pendulum(), "Two uniform rods, 1.5 kg and 1 m, 0.8 kg and 0.7 m; q = 0 hangs straight down.");
  files["cartpole/cartpole.urdf"] = commented_urdf(
      *cartpole(), "A cart of 1.2 kg on a rail with a uniform rod of 0.3 kg and 0.6 m; q = 0 stands upright.");
}

}  // namespace lacuna::generate
