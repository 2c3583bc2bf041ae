#include "scenarios/robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "scenarios/error.h"
#include "scenarios/inertial.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

/// Axes and rotations are normalised before they come here: what is left is rounding.
constexpr double kUnitTolerance = 1e-9;

bool is_rigid(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix3d rotation = pose.linear();
  return pose.matrix().allFinite() &&
         (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kUnitTolerance &&
         rotation.determinant() > 0.0;
}

void check_joint(const Joint& joint, int index, const std::vector<Link>& links, const std::string& where) {
  const auto refuse = [&](const std::string& what, const std::string& found, const std::string& expected) {
    throw InputError(where + ": " + what, found, expected);
  };
  if (joint.parent < -1 || joint.parent >= index)
    refuse("parent", fmt::format("body {}", joint.parent), fmt::format("-1 (the world) to {}", index - 1));
  if (joint.link < 0 || joint.link >= static_cast<int>(links.size()))
    refuse("link", fmt::format("index {}", joint.link), "the index of a link");
  const Link& link = links[joint.link];
  if (link.body != index || !link.in_body.isApprox(Eigen::Isometry3d::Identity(), 0.0))
    refuse("link", "link " + printable(link.name) + " away from the body's frame", "the joint's child link in it");
  if (!is_rigid(joint.origin)) refuse("origin", "no finite rotation and translation", "a rigid placement");
  if (!joint.axis.allFinite() || std::abs(joint.axis.norm() - 1.0) > kUnitTolerance)
    refuse("axis", fmt::format("length {:.6g}", joint.axis.norm()), "a unit vector");
  if (!(joint.lower <= joint.upper))
    refuse("limit", fmt::format("lower {}, upper {}", format_number(joint.lower), format_number(joint.upper)),
           "lower not above upper");
  if (!(joint.velocity >= 0.0)) refuse("limit velocity", format_number(joint.velocity), "0 or above");
  if (!(joint.effort >= 0.0)) refuse("limit effort", format_number(joint.effort), "0 or above");
}

void check_link(const Link& link, int dof, const std::string& where) {
  if (link.body < -1 || link.body >= dof)
    throw InputError(where, fmt::format("body {}", link.body), "a body of the robot or -1 (the world)");
  if (!is_rigid(link.in_body)) throw InputError(where, "no finite placement in its body", "a rigid placement");
  if (link.inertial.mass != 0.0) check_inertial(link.inertial, where);
  for (const Visual& visual : link.visuals)
    if (!visual.size.allFinite() || (visual.size.array() < 0.0).any() || !visual.mesh_scale.allFinite() ||
        !is_rigid(visual.pose))
      throw InputError(where + ": visual", "a size or placement that is negative or not finite", "a shape");
}

void insert_once(std::set<std::string>& names, const std::string& name, const std::string& where) {
  if (name.empty()) throw InputError(where, "an empty name", "a name");
  if (!names.insert(name).second) throw InputError(where, "the name " + quoted(name) + " twice", "unique names");
}

/// The corners of a shape's bounding box, in the link frame.
std::vector<Eigen::Vector3d> corners(const Visual& visual) {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  switch (visual.shape) {
    case Visual::Shape::box: half = visual.size / 2.0; break;
    case Visual::Shape::cylinder: half = {visual.size[0], visual.size[0], visual.size[1] / 2.0}; break;
    case Visual::Shape::sphere: half = Eigen::Vector3d::Constant(visual.size[0]); break;
    case Visual::Shape::mesh: return {};  // what a machine carries must not hang on whether a mesh was found
  }
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d signs((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    out.push_back(visual.pose * half.cwiseProduct(signs).eval());
  }
  return out;
}

/// The corner farthest from the link's origin; the middle of those that are equally far (an end face's centre).
Eigen::Vector3d tip_of(const Link& link) {
  double farthest = 0.0;
  std::vector<Eigen::Vector3d> all;
  for (const Visual& visual : link.visuals)
    for (const Eigen::Vector3d& corner : corners(visual)) {
      all.push_back(corner);
      farthest = std::max(farthest, corner.norm());
    }
  if (all.empty()) return 2.0 * link.inertial.com;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Eigen::Vector3d& corner : all)
    if (corner.norm() >= farthest * (1.0 - 1e-9)) {
      sum += corner;
      ++count;
    }
  return sum / count;
}

Robot::Tool find_tool(const std::vector<Link>& links) {
  for (const Link& link : links)
    if (link.name == "tool" && link.body >= 0) return {link.body, link.in_body.translation()};
  Robot::Tool last;
  for (const Link& link : links)
    if (link.body >= 0 && link.inertial.mass > 0.0) last = {link.body, link.in_body * tip_of(link)};
  return last;
}

Eigen::Isometry3d motion_of(const Joint& joint, double q) {
  return joint.prismatic() ? Eigen::Isometry3d(Eigen::Translation3d(q * joint.axis))
                           : Eigen::Isometry3d(Eigen::AngleAxisd(q, joint.axis));
}

}  // namespace

Robot::Robot(std::string name, std::vector<Joint> joints, std::vector<Link> links, const std::string& source)
    : name_(std::move(name)), joints_(std::move(joints)), links_(std::move(links)) {
  const std::string file = printable(source);
  if (joints_.empty()) throw InputError(file, "no moving joint", "a robot with at least one");
  std::set<std::string> joint_names, link_names;
  for (const Link& link : links_) {
    const std::string where = file + ": link " + printable(link.name, 60);
    insert_once(link_names, link.name, where);
    check_link(link, dof(), where);
  }
  std::vector<bool> has_child(joints_.size(), false);
  for (int i = 0; i < dof(); ++i) {
    const Joint& joint = joints_[i];
    const std::string where = file + ": joint " + printable(joint.name, 60);
    insert_once(joint_names, joint.name, where);
    check_joint(joint, i, links_, where);
    if (joint.parent >= 0) has_child[joint.parent] = true;
  }
  for (int i = 0; i < dof(); ++i) {
    const Joint& joint = joints_[i];
    const std::string where = file + ": joint " + printable(joint.name, 60);
    const Inertial moved = body_inertial(i);
    if (!(moved.mass > 0.0)) throw InputError(where, "a moved link without mass", "a mass above 0 kg");
    // With nothing beyond it, a joint that turns no inertia could be accelerated without effort.
    const double turned =
        joint.axis.dot(moved.inertia * joint.axis) + moved.mass * joint.axis.cross(moved.com).squaredNorm();
    if (!joint.prismatic() && !has_child[i] && !(turned > 0.0))
      throw InputError(where, "no inertia about its axis", "an inertia, or a mass away from the axis");
  }
  tool_ = find_tool(links_);
}

std::optional<int> Robot::find_joint(const std::string& name) const {
  for (int i = 0; i < dof(); ++i)
    if (joints_[i].name == name) return i;
  return std::nullopt;
}

std::optional<int> Robot::find_link(const std::string& name) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].name == name) return static_cast<int>(i);
  return std::nullopt;
}

Inertial Robot::body_inertial(int body, std::span<const double> link_masses) const {
  if (!link_masses.empty() && link_masses.size() != links_.size())
    throw std::invalid_argument(fmt::format("{} link masses for {} links", link_masses.size(), links_.size()));
  Inertial sum;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    if (link.body != body) continue;
    Inertial piece = link.inertial;
    if (!link_masses.empty() && piece.mass > 0.0) piece = piece.scaled(link_masses[i] / piece.mass);
    if (!link_masses.empty()) piece.mass = link_masses[i];
    if (piece.mass > 0.0) sum = welded(sum, piece.seen_from(link.in_body));
  }
  return sum;
}

double Robot::moving_mass() const {
  double sum = 0.0;
  for (const Link& link : links_)
    if (link.body >= 0) sum += link.inertial.mass;
  return sum;
}

std::shared_ptr<const Robot> Robot::with_joints_fixed(const std::vector<bool>& fixed, std::span<const double> q) const {
  struct Ride {
    int body = -1;  // in the new robot; -1 the world
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  };
  std::vector<Ride> rides;
  std::vector<Joint> joints;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Ride parent = joints_[i].parent < 0 ? Ride{} : rides[joints_[i].parent];
    Joint joint = joints_[i];
    joint.parent = parent.body;
    joint.origin = parent.pose * joint.origin;
    if (fixed[i]) {
      rides.push_back({parent.body, joint.origin * motion_of(joint, q[i])});
    } else {
      rides.push_back({static_cast<int>(joints.size()), Eigen::Isometry3d::Identity()});
      joints.push_back(std::move(joint));
    }
  }
  std::vector<Link> links = links_;
  for (Link& link : links) {
    if (link.body < 0) continue;
    const Ride& ride = rides[link.body];
    link.body = ride.body;
    link.in_body = ride.pose * link.in_body;
  }
  return std::make_shared<const Robot>(name_, std::move(joints), std::move(links), name_);
}

std::vector<Eigen::Isometry3d> Robot::link_poses(std::span<const Eigen::Isometry3d> body_poses) const {
  if (body_poses.size() != joints_.size())
    throw std::invalid_argument(fmt::format("{} body poses for {} bodies", body_poses.size(), joints_.size()));
  std::vector<Eigen::Isometry3d> out;
  out.reserve(links_.size());
  for (const Link& link : links_) out.push_back(link.body < 0 ? link.in_body : body_poses[link.body] * link.in_body);
  return out;
}

}  // namespace lacuna
