// Triangle meshes in MuJoCo's picture: its own renderer draws only meshes of its own models.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace lacuna {

struct Mesh;

/// Corners and their unit normals, nine numbers a triangle each, and a colour.
struct Facets {
  std::vector<float> points, normals;
  std::array<float, 4> rgba{};
};

/// The mesh placed by `pose` about the middle of its box, times `scale` after that. Normals are those of the faces,
/// smoothed over edges that bend by less than 30 degrees.
Facets facets_of(const Mesh& mesh, const Eigen::Isometry3d& pose, double scale, const std::array<float, 4>& rgba);

/// A perspective view as glFrustum takes it, in the picture's units.
struct PaintView {
  int width = 0, height = 0;  ///< pixels of the buffer
  Eigen::Vector3f eye, forward, up;
  float left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

/// Light from one direction.
struct Lamp {
  Eigen::Vector3f direction;  ///< in which it shines
  std::array<float, 3> ambient{}, diffuse{}, specular{};
};

/// Draws into the buffer that is bound in the current OpenGL context, behind and before what its depth already holds.
/// Leaves OpenGL's state as it was.
void paint(const std::vector<Facets>& meshes, const PaintView& view, const std::vector<Lamp>& lamps);

}  // namespace lacuna
