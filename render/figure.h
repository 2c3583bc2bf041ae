// A robot in one pose as a list of simple solids: what is drawn, apart from how it is painted.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace lacuna {

class Robot;
struct Mesh;

struct Solid {
  enum class Kind { box, cylinder, capsule, sphere, mesh };
  Kind kind = Kind::box;
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< m: box half sides; cylinder, capsule radius, -, half length (z);
                                                   ///< sphere radius. A capsule's caps lie beyond its half length.
                                                   ///< mesh half sides of the box around it
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the world
  std::array<float, 4> rgba{0.6f, 0.6f, 0.6f, 1.0f};
  int body = -1;                               ///< that carries it, with which it moves as one; -1 is the world
  std::shared_ptr<const Mesh> mesh = nullptr;  ///< of a mesh; the middle of its box lies at the pose's origin
};

/// The URDF's visuals; for bodies without any, a thin capsule from joint to joint and a ball at the centre of mass;
/// joints as dark pins along their axes, the rails of prismatic joints between their limits; where a mesh is drawn for
/// the moved body, it shows its joint itself.
/// `link_poses`: world pose of each of robot.links(). Throws std::invalid_argument for a wrong count, WorkError for
/// a pose that is not finite (a simulation that diverged).
std::vector<Solid> robot_figure(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses);

/// What carries a robot without visuals at its root from a floor at height `ground` below it. Nothing where the first
/// joint does not turn about the vertical: such a robot swings or slides through the place.
std::optional<Solid> pillar(const Robot& robot, double ground);

/// A cylinder that turns a joint, between a pin on either side of the joint's axis.
struct Piston {
  int joint = -1;
  double lever_a = 0.0,
         lever_b = 0.0;          ///< m, of the pin that the joint's parent carries, and of that on the moved body
  double lever_angle = 0.0;      ///< rad between both, seen from the axis, at position 0
  double barrel = 0.0;           ///< m, its length
  double bore = 0.0, rod = 0.0;  ///< m, diameters
};
/// Barrel, rod, the parent's pin and the moved body's, beside the links. Barrel and rod swing on their pins: neither
/// moves as one with the body that carries it. Distances and the angle between the pins are the cylinder's; where they
/// lie around the axis nobody says: the parent's pin is drawn towards the joint before, and all of it on the axis'
/// side. Throws as robot_figure.
std::vector<Solid> piston_figure(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses,
                                 const Piston& piston);

/// World position of a joint: the origin of the link it moves.
Eigen::Vector3d joint_position(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses, int joint);

/// Corners of the box around a solid, in the world.
std::array<Eigen::Vector3d, 8> corners(const Solid& solid);

}  // namespace lacuna
