#include "render/figure.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenarios/error.h"
#include "scenarios/mesh.h"
#include "scenarios/robot.h"

namespace lacuna {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::array<float, 4> kPinColor{0.15f, 0.16f, 0.18f, 1.0f};
constexpr std::array<float, 4> kRailColor{0.52f, 0.55f, 0.60f, 1.0f};
constexpr std::array<float, 4> kMountColor{0.36f, 0.39f, 0.43f, 1.0f};
constexpr std::array<float, 4> kBoneColor{0.36f, 0.46f, 0.60f, 1.0f};
constexpr double kOpenRail = 0.5;      // share of the robot's size drawn each way where a prismatic joint has no limit
constexpr double kProud = 1.12;        // a pin sticks out of its link by this factor
constexpr double kCollarProud = 1.28;  // a collar round its link
constexpr double kBone = 0.012;        // radius of a link without visuals, of the robot's size
constexpr double kPost = 0.035;        // radius of what holds the first joint, likewise
constexpr double kPlate = 0.085;       // radius of the plate below it, likewise
constexpr double kPin = 0.016;         // radius of a pin, likewise
constexpr double kCollar = 0.9;        // a link at least this long along its axis, against across it, turns in a collar
constexpr double kUpright = 0.9;       // cosine: a first axis at least as upright as this stands on a pillar
constexpr double kWall = 1.25;         // a barrel's outer over its bore
constexpr double kSmallestRobot = 1e-3;  // m: size of a robot whose joints all coincide

Isometry3d body_pose(const Robot& robot, std::span<const Isometry3d> link_poses, int body) {
  if (body < 0) return Isometry3d::Identity();
  return link_poses[robot.joints()[body].link];
}

// Rotation that carries z onto `axis`.
Eigen::Matrix3d frame_along(const Vector3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix();
}

Solid rod(Solid::Kind kind, const Vector3d& from, const Vector3d& to, double radius, std::array<float, 4> rgba) {
  Solid solid{kind, Vector3d(radius, radius, 0.5 * (to - from).norm()), Isometry3d::Identity(), rgba};
  solid.pose.translation() = 0.5 * (from + to);
  if ((to - from).norm() > 0) solid.pose.linear() = frame_along((to - from).normalized());
  return solid;
}

Solid solid_of(const Visual& visual, const Isometry3d& link_pose, int body = -1) {
  Solid solid{Solid::Kind::box, 0.5 * visual.size, link_pose * visual.pose, visual.rgba, body, nullptr};
  if (visual.shape == Visual::Shape::cylinder) {
    solid.kind = Solid::Kind::cylinder;
    solid.half = Vector3d(visual.size.x(), visual.size.x(), 0.5 * visual.size.y());
  } else if (visual.shape == Visual::Shape::sphere) {
    solid.kind = Solid::Kind::sphere;
    solid.half = Vector3d::Constant(visual.size.x());
  } else if (visual.shape == Visual::Shape::mesh) {
    solid.kind = Solid::Kind::mesh;
    solid.half = 0.5 * (visual.mesh->upper - visual.mesh->lower);
    solid.pose.translate(0.5 * (visual.mesh->upper + visual.mesh->lower));
    solid.mesh = visual.mesh;
  }
  return solid;
}

// Largest distance of a link's drawn (or heavy) parts from the origin of the body it rides on.
double reach_in_body(const Link& link) {
  double reach = (link.in_body * (2.0 * link.inertial.com)).norm();
  for (const Visual& visual : link.visuals) {
    if (!visual.drawn()) continue;
    for (const Vector3d& corner : corners(solid_of(visual, link.in_body))) reach = std::max(reach, corner.norm());
  }
  return reach;
}

double travel(const Joint& joint) {
  if (!joint.prismatic()) return 0.0;
  double far = 0.0;
  for (const double limit : {joint.lower, joint.upper}) {
    if (std::isfinite(limit)) far = std::max(far, std::abs(limit));
  }
  return far;
}

// The stretched length from the root to the farthest tip. Pins and bones are measured by it; it is the same in every
// pose, so they are, too.
double robot_size(const Robot& robot) {
  std::vector<double> reach(robot.joints().size(), 0.0);
  for (std::size_t i = 0; i < reach.size(); ++i) {
    const Joint& joint = robot.joints()[i];
    reach[i] = joint.origin.translation().norm() + travel(joint);
    if (joint.parent >= 0) reach[i] += reach[joint.parent];
  }
  double longest = kSmallestRobot;
  for (const double r : reach) longest = std::max(longest, r);
  for (const Link& link : robot.links()) {
    const double at = link.body < 0 ? 0.0 : reach[link.body];
    longest = std::max(longest, at + reach_in_body(link));
  }
  return longest;
}

bool has_visuals(const Robot& robot, int body) {
  return std::ranges::any_of(robot.links(), [body](const Link& link) {
    return link.body == body && std::ranges::any_of(link.visuals, [](const Visual& v) { return v.drawn(); });
  });
}

bool has_mesh(const Robot& robot, int body) {
  return std::ranges::any_of(robot.links(), [body](const Link& link) {
    return link.body == body && std::ranges::any_of(link.visuals, [](const Visual& v) { return v.mesh != nullptr; });
  });
}

// How far the visuals of a body stretch from a joint: along its axis and across it.
struct Stretch {
  double along = 0.0, across = 0.0;
};

Stretch stretch(const Robot& robot, std::span<const Isometry3d> link_poses, int body, const Vector3d& center,
                const Eigen::Matrix3d& frame) {
  Stretch result;
  for (std::size_t i = 0; i < robot.links().size(); ++i) {
    if (robot.links()[i].body != body) continue;
    for (const Visual& visual : robot.links()[i].visuals) {
      if (!visual.drawn()) continue;
      for (const Vector3d& corner : corners(solid_of(visual, link_poses[i]))) {
        const Vector3d local = frame.transpose() * (corner - center);
        result.along = std::max(result.along, std::abs(local.z()));
        result.across = std::max({result.across, std::abs(local.x()), std::abs(local.y())});
      }
    }
  }
  return result;
}

// A hinge across its links is a pin that shows at both sides; one that turns a link about its length is a collar.
Solid turning_joint(const Robot& robot, std::span<const Isometry3d> link_poses, int index, double size) {
  const Joint& joint = robot.joints()[index];
  const Isometry3d& pose = link_poses[joint.link];
  Solid solid{Solid::Kind::cylinder, Vector3d::Zero(), pose, kPinColor, index};
  // Measured in the link's own frame turned with it, so that a pin keeps its form in every pose.
  solid.pose.linear() = pose.linear() * frame_along(joint.axis);
  const Stretch child = stretch(robot, link_poses, index, pose.translation(), solid.pose.linear());
  double radius = kPin * size, half = 2.0 * radius;
  if (child.across > 0 && child.along > kCollar * child.across) {
    radius = kCollarProud * child.across;
    half = 0.12 * radius;
  } else if (child.along > 0) {
    half = child.along;
    if (joint.parent >= 0 && has_visuals(robot, joint.parent)) {
      const Stretch parent = stretch(robot, link_poses, joint.parent, pose.translation(), solid.pose.linear());
      if (parent.along < parent.across) half = std::max(half, parent.along);
    }
    half *= kProud;
  }
  solid.half = Vector3d(radius, radius, half);
  return solid;
}

// The rail of a prismatic joint from limit to limit, with a stop at either end.
void add_rail(const Robot& robot, std::span<const Isometry3d> link_poses, const Joint& joint, double size,
              std::vector<Solid>& figure) {
  const Isometry3d zero = body_pose(robot, link_poses, joint.parent) * joint.origin;
  const auto reach = [&](double limit, double open) { return std::isfinite(limit) ? limit : open; };
  const Vector3d from = zero * (joint.axis * reach(joint.lower, -kOpenRail * size));
  const Vector3d to = zero * (joint.axis * reach(joint.upper, kOpenRail * size));
  figure.push_back(rod(Solid::Kind::cylinder, from, to, kBone * size, kRailColor));
  figure.back().body = joint.parent;
  for (const Vector3d& end : {from, to}) {
    Solid stop{Solid::Kind::box, Vector3d(2.2, 2.2, 0.6) * (kBone * size), zero, kPinColor};
    stop.pose.linear() = zero.linear() * frame_along(joint.axis);
    stop.pose.translation() = end;
    stop.body = joint.parent;
    figure.push_back(stop);
  }
}

// A root that has no visuals: a plate on the floor and posts to the joints on it.
void add_mount(const Robot& robot, double size, std::vector<Solid>& figure) {
  bool turns = false;
  for (const Joint& joint : robot.joints()) {
    if (joint.parent >= 0) continue;
    turns = turns || !joint.prismatic();
    const Vector3d to = joint.origin.translation();
    if (to.norm() > kBone * size) {
      const double radius = joint.prismatic() ? 1.3 * kBone : kPost;
      figure.push_back(rod(Solid::Kind::cylinder, Vector3d::Zero(), to, radius * size, kMountColor));
    }
  }
  if (!turns) return;  // a rail needs no plate
  figure.push_back(
      {Solid::Kind::cylinder, Vector3d(kPlate, kPlate, 0.1 * kPlate) * size, Isometry3d::Identity(), kMountColor});
  figure.back().pose.translation().z() = 0.1 * kPlate * size;
}

// A moving body that has no visuals: rods to the joints it carries, and, where it carries none, to a ball at its mass.
void add_bones(const Robot& robot, std::span<const Isometry3d> link_poses, int body, double size,
               std::vector<Solid>& figure) {
  const std::size_t first = figure.size();
  const Isometry3d pose = body_pose(robot, link_poses, body);
  const double radius = kBone * size;
  bool carries = false;
  for (const Joint& joint : robot.joints()) {
    if (joint.parent != body) continue;
    carries = true;
    const Vector3d to = pose * joint.origin.translation();
    if ((to - pose.translation()).norm() > radius) {
      figure.push_back(rod(Solid::Kind::capsule, pose.translation(), to, radius, kBoneColor));
    }
  }
  const Vector3d mass = pose * robot.body_inertial(body).com;
  const bool apart = (mass - pose.translation()).norm() > radius;
  if (apart && !carries) figure.push_back(rod(Solid::Kind::capsule, pose.translation(), mass, radius, kBoneColor));
  if (apart || !carries) {
    figure.push_back({Solid::Kind::sphere, Vector3d::Constant(3.0 * radius), Isometry3d::Identity(), kBoneColor});
    figure.back().pose.translation() = mass;
  }
  for (std::size_t i = first; i < figure.size(); ++i) figure[i].body = body;
}

/// Away from the joint's axis towards the joint before it.
Vector3d towards_parent(const Robot& robot, std::span<const Isometry3d> link_poses, const Joint& joint,
                        const Vector3d& axis) {
  const Vector3d here = link_poses[joint.link].translation();
  Vector3d way = body_pose(robot, link_poses, joint.parent).translation() - here;
  way -= way.dot(axis) * axis;
  return way.norm() > 1e-6 ? way.normalized() : Vector3d(frame_along(axis).col(0));
}

void check_poses(const Robot& robot, std::span<const Isometry3d> link_poses) {
  if (link_poses.size() != robot.links().size()) {
    throw std::invalid_argument(std::to_string(link_poses.size()) + " poses for " +
                                std::to_string(robot.links().size()) + " links");
  }
  for (std::size_t i = 0; i < link_poses.size(); ++i) {
    if (!link_poses[i].matrix().allFinite()) {
      throw WorkError("link " + quoted(robot.links()[i].name) + ": its pose is not finite and cannot be drawn");
    }
  }
}

}  // namespace

std::vector<Solid> robot_figure(const Robot& robot, std::span<const Isometry3d> link_poses) {
  check_poses(robot, link_poses);
  const double size = robot_size(robot);
  std::vector<Solid> figure;
  for (std::size_t i = 0; i < robot.links().size(); ++i) {
    for (const Visual& visual : robot.links()[i].visuals)
      if (visual.drawn()) figure.push_back(solid_of(visual, link_poses[i], robot.links()[i].body));
  }
  if (!has_visuals(robot, -1)) add_mount(robot, size, figure);
  for (int body = 0; body < robot.dof(); ++body) {
    if (!has_visuals(robot, body)) add_bones(robot, link_poses, body, size, figure);
  }
  for (int joint = 0; joint < robot.dof(); ++joint) {
    const Joint& it = robot.joints()[joint];
    if (has_mesh(robot, joint)) continue;
    if (it.prismatic()) {
      add_rail(robot, link_poses, it, size, figure);
    } else {
      figure.push_back(turning_joint(robot, link_poses, joint, size));
    }
  }
  return figure;
}

std::vector<Solid> piston_figure(const Robot& robot, std::span<const Isometry3d> link_poses, const Piston& piston) {
  check_poses(robot, link_poses);
  const Vector3d at = joint_position(robot, link_poses, piston.joint);  // throws for a joint that is not there
  const Joint& joint = robot.joints()[piston.joint];
  const Isometry3d zero = body_pose(robot, link_poses, joint.parent) * joint.origin;
  const Isometry3d& moved = link_poses[joint.link];
  const Vector3d axis = (zero.linear() * joint.axis).normalized();
  const Eigen::AngleAxisd turned(Eigen::Matrix3d(zero.linear().transpose() * moved.linear()));
  const double q = turned.angle() * turned.axis().dot(joint.axis.normalized());

  Eigen::Matrix3d frame = frame_along(axis);
  double beside = stretch(robot, link_poses, piston.joint, at, frame).along;
  if (joint.parent >= 0) {
    const Stretch parent = stretch(robot, link_poses, joint.parent, at, frame);
    if (parent.along < parent.across) beside = std::max(beside, parent.along);
  }
  const double radius = 0.5 * kWall * piston.bore;
  const Vector3d middle = at + (beside + 1.2 * radius) * axis;
  const Vector3d way = towards_parent(robot, link_poses, joint, axis);
  const Vector3d from = middle + piston.lever_a * way;
  const Vector3d to = middle + piston.lever_b * (Eigen::AngleAxisd(q + piston.lever_angle, axis) * way);
  const Vector3d along = (to - from).norm() > 0 ? Vector3d((to - from).normalized()) : axis;
  const Vector3d gland = from + std::min(piston.barrel, (to - from).norm()) * along;

  std::vector<Solid> out{rod(Solid::Kind::cylinder, from, gland, radius, kRailColor),
                         rod(Solid::Kind::cylinder, gland, to, 0.5 * piston.rod, kPinColor)};
  for (const Vector3d& pin : {from, to})
    out.push_back(
        rod(Solid::Kind::cylinder, pin - 1.1 * radius * axis, pin + 1.1 * radius * axis, 0.45 * radius, kPinColor));
  out[0].body = out[2].body = joint.parent;
  out[1].body = out[3].body = piston.joint;
  return out;
}

std::optional<Solid> pillar(const Robot& robot, double ground) {
  if (robot.dof() == 0 || has_visuals(robot, -1)) return std::nullopt;
  const Joint& first = robot.joints().front();
  const double upright = std::abs((first.origin.linear() * first.axis).z());
  if (first.prismatic() || upright < kUpright || !(ground < 0)) return std::nullopt;
  const double radius = 0.6 * kPlate * robot_size(robot);
  return rod(Solid::Kind::cylinder, Vector3d(0, 0, ground), Vector3d::Zero(), radius, kMountColor);
}

Vector3d joint_position(const Robot& robot, std::span<const Isometry3d> link_poses, int joint) {
  if (joint < 0 || joint >= robot.dof()) {
    throw std::invalid_argument("joint " + std::to_string(joint) + " of a robot with " + std::to_string(robot.dof()));
  }
  return link_poses[robot.joints()[joint].link].translation();
}

std::array<Vector3d, 8> corners(const Solid& solid) {
  Vector3d half = solid.half;
  if (solid.kind == Solid::Kind::capsule) half.z() += half.x();
  std::array<Vector3d, 8> result;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1);
    result[i] = solid.pose * half.cwiseProduct(sign);
  }
  return result;
}

}  // namespace lacuna
