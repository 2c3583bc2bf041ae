// Where a picture is taken from. One camera serves all engines and poses of a comparison, so pictures lie over each
// other pixel by pixel.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace lacuna {

class Robot;

struct Camera {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m, world point in the middle of the picture
  double distance = 3.0;                             ///< m, from the target
  double azimuth = 2.2;                              ///< rad, direction of sight about world z; 0 looks along +x
  double elevation = -0.33;                          ///< rad, of the direction of sight; negative looks down
  double field_of_view = 0.5;                        ///< rad, vertical, in a picture of `aspect`
  double aspect = 4.0 / 3.0;                         ///< width over height that the fit was made for; a narrower
                                                     ///< picture sees more above and below, never less at the sides
  double radius = 1.0;                               ///< m, of the scene: scales the light and the floor's pattern
  double ground = 0.0;                               ///< m, height of the floor in the world

  /// Unit vectors: direction of sight, to the right, upwards in the picture.
  Eigen::Matrix3d axes() const;
};

/// A point's place in a picture: x, y in pixels from the top left; depth in m along the direction of sight.
Eigen::Vector3d project(const Camera& camera, int width, int height, const Eigen::Vector3d& point);

/// Tangent of half the vertical angle in a picture of this size.
double half_height_tangent(const Camera& camera, int width, int height);

/// The camera that sees all of the robot in all the poses, from the side in which most joints turn, obliquely from
/// above. Deterministic. `pose_sets`: link poses, one vector for each pose; at least one.
Camera fit_camera(const Robot& robot, std::span<const std::vector<Eigen::Isometry3d>> pose_sets,
                  double aspect = 4.0 / 3.0);

}  // namespace lacuna
