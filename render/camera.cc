#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "render/figure.h"
#include "scenarios/robot.h"

namespace lacuna {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kQuarterTurn =
    0.55;                            // rad, from looking straight along the hinges: shows depth, keeps the motion plane
constexpr double kLookDown = -0.30;  // rad
constexpr double kMargin = 1.12;     // free border round the robot
constexpr double kHeadroom = 0.05;   // share of the picture's height kept free for the caption
constexpr double kSmallest = 1e-3;   // m, radius of a scene whose points all coincide
constexpr int kFitRounds = 8;        // each halves the error of the centring at least

// Azimuth of the horizontal direction about which most of the joints turn; slides count across their direction.
double hinge_azimuth(const Robot& robot, std::span<const std::vector<Isometry3d>> pose_sets) {
  double xx = 0, yy = 0, xy = 0;
  for (const auto& poses : pose_sets) {
    for (const Joint& joint : robot.joints()) {
      Vector3d axis = poses.at(static_cast<std::size_t>(joint.link)).linear() * joint.axis;
      if (joint.prismatic()) axis = Vector3d::UnitZ().cross(axis);
      xx += axis.x() * axis.x();
      yy += axis.y() * axis.y();
      xy += axis.x() * axis.y();
    }
  }
  // Nothing turns about a horizontal axis (or all directions weigh the same): look along y.
  const double spread = std::hypot(xx - yy, 2 * xy);
  double azimuth = spread > 1e-9 * (xx + yy) && spread > 0 ? 0.5 * std::atan2(2 * xy, xx - yy) : std::numbers::pi / 2;
  // Both ways along an axis are as good; the one that looks towards +y is taken, so x grows to the right.
  if (std::sin(azimuth) < 0) azimuth += std::numbers::pi;
  return azimuth;
}

// Moves the camera in its own plane until the points' edges lie evenly about the middle, then backs off until they fit.
void frame_points(const std::vector<Vector3d>& points, Camera& camera) {
  const Eigen::Matrix3d axes = camera.axes();
  const double up = std::tan(0.5 * camera.field_of_view) / kMargin, side = up * camera.aspect;
  for (int round = 0; round < kFitRounds; ++round) {
    double distance = 0, left = 0, right = 0, low = 0, high = 0;
    bool first = true;
    for (const Vector3d& point : points) {
      const Vector3d local = axes.transpose() * (point - camera.target);
      distance = std::max({distance, std::abs(local.y()) / side - local.x(), std::abs(local.z()) / up - local.x()});
    }
    camera.distance = std::max(distance, camera.radius * kSmallest);
    for (const Vector3d& point : points) {
      const Vector3d local = axes.transpose() * (point - camera.target);
      const double depth = std::max(camera.distance + local.x(), kSmallest * camera.radius);
      const double y = local.y() / depth, z = local.z() / depth;
      left = first ? y : std::min(left, y);
      right = first ? y : std::max(right, y);
      low = first ? z : std::min(low, z);
      high = first ? z : std::max(high, z);
      first = false;
    }
    if (round + 1 == kFitRounds) break;
    camera.target += camera.distance * 0.5 * ((left + right) * axes.col(1) + (low + high) * axes.col(2));
  }
  camera.distance *= 1.0 + kHeadroom;
  camera.target += camera.distance * kHeadroom * std::tan(0.5 * camera.field_of_view) * axes.col(2);
}

}  // namespace

Eigen::Matrix3d Camera::axes() const {
  Eigen::Matrix3d result;
  const double ca = std::cos(azimuth), sa = std::sin(azimuth), ce = std::cos(elevation), se = std::sin(elevation);
  result.col(0) = Vector3d(ca * ce, sa * ce, se);
  result.col(1) = Vector3d(sa, -ca, 0);
  result.col(2) = Vector3d(-ca * se, -sa * se, ce);
  return result;
}

double half_height_tangent(const Camera& camera, int width, int height) {
  const double aspect = static_cast<double>(width) / height;
  return std::tan(0.5 * camera.field_of_view) * std::max(1.0, camera.aspect / aspect);
}

Vector3d project(const Camera& camera, int width, int height, const Vector3d& point) {
  const Vector3d local = camera.axes().transpose() * (point - camera.target);
  const double depth = camera.distance + local.x();
  const double scale = 0.5 * height / (half_height_tangent(camera, width, height) * depth);
  return {0.5 * width + scale * local.y(), 0.5 * height - scale * local.z(), depth};
}

Camera fit_camera(const Robot& robot, std::span<const std::vector<Isometry3d>> pose_sets, double aspect) {
  if (pose_sets.empty() || !(aspect > 0)) throw std::invalid_argument("a camera needs poses and an aspect");
  std::vector<Vector3d> points{Vector3d::Zero()};
  for (const auto& poses : pose_sets) {
    for (const Solid& solid : robot_figure(robot, poses)) {
      for (const Vector3d& corner : corners(solid)) points.push_back(corner);
    }
  }
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  Camera camera;
  camera.aspect = aspect;
  camera.target = 0.5 * (low + high);
  camera.radius = std::max(0.5 * (high - low).norm(), kSmallest);
  camera.ground = low.z();
  camera.azimuth = hinge_azimuth(robot, pose_sets) + kQuarterTurn;
  camera.elevation = kLookDown;
  frame_points(points, camera);
  return camera;
}

}  // namespace lacuna
