// A robot as the engines see it: a tree of rigid bodies, each moved by one joint of one degree of freedom.
//
// Units SI (m, kg, rad). Built once from URDF, validated there, immutable afterwards and safe to share.
// Fixed joints are folded away: every link stays in `links()`, riding on the body that carries it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lacuna {

/// Mass properties of one rigid piece, expressed in a stated frame.
struct Inertial {
  double mass = 0.0;                                  ///< kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< m, centre of mass in the frame
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< kg m^2, about the centre of mass, axes of the frame

  /// The same piece seen from another frame; `pose` places the present frame in the new one.
  Inertial seen_from(const Eigen::Isometry3d& pose) const;
  /// This piece made `factor` times as heavy with its geometry unchanged (inertia scales with mass).
  Inertial scaled(double factor) const;
};

/// Two pieces, expressed in one frame, welded together (parallel-axis theorem).
Inertial welded(const Inertial& a, const Inertial& b);

struct Mesh;  // scenarios/mesh.h

/// What is drawn for a link. Of a mesh a robot's file gives the name: it is drawn once with_meshes (scenarios/mesh.h)
/// has read it.
struct Visual {
  enum class Shape { box, cylinder, sphere, mesh };
  Shape shape = Shape::box;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< m: box x,y,z; cylinder radius,length(z),0; sphere radius,0,0;
                                                   ///< mesh 0,0,0
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the link frame
  std::array<float, 4> rgba{0.6f, 0.6f, 0.6f, 1.0f};
  std::string mesh_file = {};  ///< as written: a relative name, file:// or package://
  Eigen::Vector3d mesh_scale = Eigen::Vector3d::Ones();
  std::shared_ptr<const Mesh> mesh = nullptr;  ///< in m, scaled; null: not read, so not drawn

  bool drawn() const { return shape != Shape::mesh || mesh != nullptr; }
};

struct Link {
  std::string name;
  int body = -1;                                              ///< body that carries the link; -1 is the world
  Eigen::Isometry3d in_body = Eigen::Isometry3d::Identity();  ///< link frame in that body's frame
  Inertial inertial;                                          ///< in the link frame; mass 0 where the URDF has none
  std::vector<Visual> visuals;
};

enum class JointType { revolute, continuous, prismatic };

/// Joint i moves body i. The body frame is the URDF child-link frame: `origin` then motion along or about `axis`.
struct Joint {
  std::string name;
  JointType type = JointType::revolute;
  int parent = -1;  ///< body index, smaller than this joint's own; -1 is the world
  int link = -1;    ///< index of the child link in `links()`
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();   ///< joint frame in the parent body's frame, at q = 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();            ///< unit vector in the joint frame
  double lower = -std::numeric_limits<double>::infinity();    ///< rad or m
  double upper = std::numeric_limits<double>::infinity();     ///< rad or m
  double velocity = std::numeric_limits<double>::infinity();  ///< rad/s or m/s
  double effort = std::numeric_limits<double>::infinity();    ///< N m or N

  bool prismatic() const { return type == JointType::prismatic; }
};

class Robot {
 public:
  /// Checks the tree (parents before children, unit axes, positive masses of moving bodies, triangle inequality of
  /// every inertia, unique names); throws InputError naming `source` and the joint or link.
  Robot(std::string name, std::vector<Joint> joints, std::vector<Link> links, const std::string& source);

  /// Reads a URDF through urdfdom. Revolute, continuous, prismatic and fixed joints; trees with one root; rotated
  /// inertial frames. At most 16 MiB, 1,000 links. Throws InputError. `notes` receives what was ignored (mimic, ...).
  /// Meshes are named, not read.
  static std::shared_ptr<const Robot> from_urdf(const std::filesystem::path& file,
                                                std::vector<std::string>* notes = nullptr);
  static std::shared_ptr<const Robot> from_urdf_text(const std::string& xml, const std::string& source,
                                                     std::vector<std::string>* notes = nullptr);

  const std::string& name() const { return name_; }
  int dof() const { return static_cast<int>(joints_.size()); }
  const std::vector<Joint>& joints() const { return joints_; }
  const std::vector<Link>& links() const { return links_; }
  std::optional<int> find_joint(const std::string& name) const;
  std::optional<int> find_link(const std::string& name) const;

  /// Inertial of body `body` in its own frame, all links that ride on it welded together; `link_masses`, one per link
  /// (kg), replace the URDF's masses (each link's inertia scales with its mass). An empty span: the URDF's own.
  Inertial body_inertial(int body, std::span<const double> link_masses = {}) const;

  /// Sum over moving links, kg.
  double moving_mass() const;

  /// Where a payload is carried: the origin of the link named `tool`, else the last link's tip (the visual corner
  /// farthest from the joint; without visuals, which meshes do not count among, twice the centre of mass).
  struct Tool {
    int body = -1;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, in the body frame
  };
  const Tool& tool() const { return tool_; }

  /// The same robot with some joints ([joint]: whether) fixed at `q` (rad or m), their links riding on what carries
  /// them.
  std::shared_ptr<const Robot> with_joints_fixed(const std::vector<bool>& fixed, std::span<const double> q) const;

  /// World pose of every link from the world poses of the bodies.
  std::vector<Eigen::Isometry3d> link_poses(std::span<const Eigen::Isometry3d> body_poses) const;

 private:
  std::string name_;
  std::vector<Joint> joints_;
  std::vector<Link> links_;
  Tool tool_;
};

}  // namespace lacuna
