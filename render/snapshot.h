// A robot's picture, drawn in memory: no display, no graphics card.
//
//   Camera camera = fit_camera(robot, all_poses);             // one for all engines
//   Image image = render_snapshot(robot, poses, camera, {.caption = "simbody"});
//   write_png("pose.png", image);
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/figure.h"
#include "render/image.h"

namespace lacuna {

class Robot;

/// A ring about a joint with a label beside it; drawn over everything, so no link hides it.
struct Marker {
  int joint = -1;
  std::string label;  ///< empty: the joint's name
  std::array<std::uint8_t, 3> color{214, 20, 90};
};

struct SnapshotOptions {
  int width = 960;  ///< pixels, 1..kMaxImageSide
  int height = 720;
  std::string caption;     ///< the engine's name, large, top left
  std::string subcaption;  ///< a line below it: pose, time. Printable ASCII; others show as ?
  std::vector<Marker> markers;
  std::vector<Piston> pistons;  ///< drawn with the robot
};

/// False where this build or machine cannot draw; `reason` (may be null) then says why.
bool render_available(std::string* reason = nullptr);

/// `link_poses`: world pose of each of robot.links() (Robot::link_poses). Same arguments, same bytes.
/// Safe from several threads; they take turns.
/// Throws InputError for a size out of range, std::invalid_argument for a wrong number of poses, a joint that is not
/// there or a camera that sees nothing, WorkError for poses that are not finite or with render_available's reason.
Image render_snapshot(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses, const Camera& camera,
                      const SnapshotOptions& options);

}  // namespace lacuna
