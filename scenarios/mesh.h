// Triangle meshes that a robot's file names for its links' looks. They are drawn and nothing else: no mass, inertia or
// tool depends on whether a mesh was found or this build can read it.
//
//   std::vector<std::string> notes;
//   robot = with_meshes(*robot, {"arm/", {"/opt/ros/share"}}, notes);
//
// Names come from outside: `visual/link.stl` beside the robot's file, `file:///whole/path`, `package://NAME/path`. A
// file is read only where it lies, symlinks resolved, in the tree of the robot's folder or of a package path.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lacuna {

class Robot;

/// At least one triangle, every index below the number of vertices, every number finite.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;                ///< m, in the visual's frame
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();      ///< m, corners of the box around it
  Eigen::Vector3d upper = Eigen::Vector3d::Zero();
};

/// What a robot may make us read and keep.
struct MeshLimits {
  std::size_t files = 200;
  std::uintmax_t file_bytes = std::uintmax_t{64} << 20;
  std::uintmax_t total_bytes = std::uintmax_t{256} << 20;
  std::size_t triangles = 1'000'000;  ///< of one file; all together at most twice as many
  double size = 1e4;                  ///< m, of one mesh
};

/// Whether this build reads meshes; `reason` (may be null) says why not.
bool meshes_available(std::string* reason = nullptr);

/// The mesh in the bytes of an STL (text or binary), OBJ or Collada file, all its pieces in one, in the file's unit (a
/// Collada file's own unit and the places of its nodes applied). `format`: stl, obj or dae. Nothing but `bytes` is
/// read. Throws InputError naming `source`; WorkError with meshes_available's reason.
Mesh read_mesh(const std::string& bytes, const std::string& format, const std::string& source,
               const MeshLimits& limits = {});

/// The same mesh, every coordinate times its factor; a mirrored one keeps its outside outside. Throws InputError naming
/// `source` where the result is not finite or larger than the limit.
Mesh scaled(Mesh mesh, const Eigen::Vector3d& factors, const std::string& source, const MeshLimits& limits = {});

/// Where meshes may lie.
struct MeshFolders {
  std::filesystem::path robot;  ///< folder of the robot's file
  std::vector<std::filesystem::path>
      packages;  ///< `package://NAME/x` is DIR/NAME/x, or DIR/x where DIR is called NAME;
                 ///< relative names are looked for here, too, after the robot's folder
};

/// The file that `name` stands for; none where there is no such file, and `why` then says so. Throws InputError naming
/// `where` for a name that leaves the folders.
std::optional<std::filesystem::path> find_mesh(const std::string& name, const MeshFolders& folders,
                                               const std::string& where, std::string& why);

/// The robot with the meshes of its visuals read. One that is not found, or of a kind that is not read, stays undrawn
/// and `notes` says so; one that is found and no mesh throws InputError, as do package paths that are no folders.
std::shared_ptr<const Robot> with_meshes(const Robot& robot, const MeshFolders& folders,
                                         std::vector<std::string>& notes, const MeshLimits& limits = {});

}  // namespace lacuna
