#include "backends/featherstone/mount.h"

#include <cmath>

namespace lacuna {
namespace {

/// What is smaller than this beside 1 is rounding of products of rotations.
constexpr double kRounding = 1e-15;
/// Sine of the least angle between axes whose common normal fixes the origin: its foot is at most ten times as far away
/// as the joints are apart.
constexpr double kSkew = 0.1;

double snapped(double x, double scale = 1.0) { return std::fabs(x) <= kRounding * scale ? 0.0 : x; }

Eigen::Vector3d perpendicular(const Eigen::Vector3d& z) {
  Eigen::Index least = 0;
  z.cwiseAbs().minCoeff(&least);
  return (Eigen::Vector3d::Unit(least) - z[least] * z).normalized();
}

/// Common normal of the line along z through the origin and the line along d through p.
Eigen::Vector3d common_normal(const Eigen::Vector3d& z, const Eigen::Vector3d& d, const Eigen::Vector3d& p) {
  Eigen::Vector3d n = z.cross(d);
  if (n.norm() <= kRounding) n = p - p.dot(z) * z;  // parallel: from one to the other
  if (n.norm() <= kRounding) return perpendicular(z);
  n.normalize();
  return (n - n.dot(z) * z).normalized();
}

Eigen::Matrix3d frame(const Eigen::Vector3d& x, const Eigen::Vector3d& z) {
  Eigen::Matrix3d out;
  out << x, z.cross(x), z;
  return out;
}

/// A joint's axis and origin as its parent's URDF frame sees them.
struct Line {
  explicit Line(const Joint& joint)
      : direction(joint.origin.linear() * joint.axis), point(joint.origin.translation()) {}
  Eigen::Vector3d direction, point;
};

/// Puts the frame of `body` at the common normal with its child's axis; a child without children follows suit.
void meet(const Joint& joint, const Joint& child, bool main, bool leaf, Mount& body, Mount& next) {
  const Eigen::Vector3d z = joint.axis;
  const Line line(child);
  const Eigen::Vector3d& d = line.direction;
  const Eigen::Vector3d n = z.cross(d), x = common_normal(z, d, line.point);
  const bool skew = n.norm() > kSkew;
  if (leaf) {
    next.align = frame(child.origin.linear().transpose() * x, child.axis);
    if (skew) next.origin = line.point.cross(z).dot(n) / n.squaredNorm() * child.axis;
  }
  if (!main) return;
  body.align = frame(x, z);
  const Eigen::Vector3d child_origin = line.point + child.origin.linear() * next.origin;
  body.origin = (skew ? line.point.cross(d).dot(n) / n.squaredNorm() : child_origin.dot(z)) * z;
}

/// The way from the parent's frame to the child's, both chosen.
void connect(const Joint& joint, const Mount& parent, Mount& mount) {
  const Eigen::Vector3d z = parent.align.col(2);
  const Line line(joint);
  const Eigen::Vector3d x = common_normal(z, line.direction, line.point), side = z.cross(x);
  const Eigen::Matrix3d rest = frame(x, line.direction);  // parent's URDF frame <- rest frame
  mount.to_rest = rest.transpose() * parent.align;

  mount.cos_swing = snapped(parent.align.col(0).dot(x));
  mount.sin_swing = snapped(parent.align.col(1).dot(x));
  mount.swings = mount.sin_swing != 0.0 || mount.cos_swing < 0.0;
  mount.cos_tilt = snapped(z.dot(line.direction));
  mount.sin_tilt = snapped(-side.dot(line.direction));
  const bool quarter = mount.cos_tilt == 0.0 && mount.sin_tilt > 0.0;
  const bool none = mount.sin_tilt == 0.0 && mount.cos_tilt > 0.0;
  mount.tilt = quarter ? Tilt::quarter : none ? Tilt::none : Tilt::any;

  const Eigen::Vector3d between = line.point + joint.origin.linear() * mount.origin - parent.origin;
  const double size = line.point.norm() + mount.origin.norm() + parent.origin.norm();
  for (Eigen::Index k = 0; k < 3; ++k) mount.shift[k] = snapped(rest.col(k).dot(between), size);
  mount.shifts = mount.prismatic || !mount.shift.isZero(0.0);
  const Eigen::Vector3d own_x = joint.origin.linear() * mount.align.col(0);
  mount.offset = snapped(std::atan2(rest.col(1).dot(own_x), rest.col(0).dot(own_x)));
}

}  // namespace

std::vector<Mount> mounts_of(const Robot& robot) {
  const std::vector<Joint>& joints = robot.joints();
  const std::size_t n = joints.size();
  std::vector<Mount> mounts(n);
  std::vector<std::vector<std::size_t>> children(n);
  for (std::size_t i = 0; i < n; ++i) {
    mounts[i].parent = joints[i].parent;
    mounts[i].prismatic = joints[i].prismatic();
    mounts[i].align = frame(perpendicular(joints[i].axis), joints[i].axis);
    if (joints[i].parent >= 0) children[joints[i].parent].push_back(i);
  }
  for (std::size_t i = n; i-- > 0;) {  // a child's own frame is settled before its parent's
    for (const std::size_t c : children[i]) {
      meet(joints[i], joints[c], c == children[i].front(), children[c].empty(), mounts[i], mounts[c]);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (joints[i].parent < 0) {
      mounts[i].to_rest = (joints[i].origin.linear() * mounts[i].align).transpose();
    } else {
      connect(joints[i], mounts[joints[i].parent], mounts[i]);
    }
  }
  return mounts;
}

}  // namespace lacuna
