// Our own rigid-body dynamics: Featherstone's recursive algorithms over any scalar type.
//
// Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008: RNEA (table 5.1), CRBA (6.2), ABA (7.1), with spatial
// vectors kept as two three-vectors. The frames of mount.h make motion subspaces unit vectors, U and D a column of the
// articulated inertia, and every turn one about a coordinate axis. Linear accelerations are those of the frames'
// origins as material points (Luh, Walker, Paul 1980), so that no linear velocity is needed.
//
// Structure (tree, placements) is shared by all lanes; mass properties and gravity may differ from lane to lane.
// No allocation after construction. Not shared between threads.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "backends/featherstone/articulated.h"
#include "backends/featherstone/mount.h"
#include "scenarios/robot.h"

namespace lacuna {

/// Mass properties of one body, linear in its masses: about the body's origin, axes of the kernel frame.
template <class T>
struct BodyMass {
  T mass = T(1.0);  ///< kg
  Vec3<T> moment;   ///< kg m, mass times centre of mass
  Sym3<T> inertia;  ///< kg m^2, about the origin
};

template <class T>
class Tree {
 public:
  explicit Tree(const Robot& robot);

  int dof() const { return static_cast<int>(bodies_.size()); }

  /// Mass properties of one lane, given in the body's URDF frame.
  void set_inertial(int body, int lane_index, const Inertial& inertial);
  /// Inertia reflected to a joint by what turns with its motor, kg m^2 (kg): added to that joint's own acceleration
  /// only.
  void set_armature(int joint, int lane_index, double inertia);
  void set_gravity(int lane_index, const Eigen::Vector3d& gravity);

  /// Articulated-body algorithm. `free[i]` is 1 where joint i moves and 0 where it is held: then a[i] = 0 and
  /// imbalance[i] is the effort (N m, N) that whatever holds it must take up. Where it moves, imbalance[i] is the
  /// effort that accelerates its articulated inertia. Arrays of dof() values.
  void forward_dynamics(const T* q, const T* v, const T* tau, const T* free, T* a, T* imbalance);

  /// Recursive Newton-Euler: tau for the motion (q, v, a), gravity included.
  void inverse_dynamics(const T* q, const T* v, const T* a, T* tau);

  /// Composite-rigid-body algorithm; row-major dof x dof.
  void mass_matrix(const T* q, T* mass);

  /// World poses of the bodies' URDF frames (one lane: meant for double).
  void body_poses(const T* q, std::vector<Eigen::Isometry3d>& poses) const requires std::same_as<T, double>;

 private:
  struct Body {
    Mount mount;
    bool leaf = true, last = true;  ///< no child; the last among its siblings, hence the first to reach the parent
    BodyMass<T> mass;
    T armature = T(0.0);  ///< kg m^2 (kg)
    Vec3<T> fall;         ///< m/s^2, roots: minus gravity, rest frame
    // Scratch of one evaluation. The rest frame is the parent's, moved along the mount but not by the joint.
    T c = T(1.0), s = T(0.0);    ///< cosine and sine of the joint's turn about z
    T slide = T(0.0);            ///< m, along z from the rest frame's place to ours
    Vec3<T> omega;               ///< rad/s
    Vec3<T> bias_ang, bias_lin;  ///< rad/s^2, m/s^2, rest frame: acceleration by velocity products
    Vec3<T> alpha, acc;          ///< rad/s^2, m/s^2
    Vec3<T> moment, force;       ///< N m, N: of the body's own motion; then of all that it carries
    Articulated<T> carried;      ///< what the children hand down
    Vec3<T> u_ang, u_lin;        ///< U = articulated inertia times the joint's unit motion
    T d_inv = T(0.0), u = T(0.0);
    T kept = T(0.0);   ///< share of U that the joint passes on: 1 where it is held
    T total = T(0.0);  ///< kg, of the composite
    Vec3<T> first;     ///< kg m, of the composite
    Sym3<T> second;    ///< kg m^2, of the composite
  };

  void place_body(Body& body, const T& q);
  void move_body(Body& body, const T& v);
  Articulated<T> gathered(const Body& body) const;
  void solve_joint(Body& body, const Articulated<T>& I, const T& tau, const T& free);
  void reduce_revolute(const Body& body, Articulated<T>& I) const;
  void reduce_prismatic(const Body& body, Articulated<T>& I) const;
  void solve_root(Body& body, const T& tau, const T& free);
  template <bool to_root>
  void give(const Body& body, const Articulated<T>& I, Body& parent) const;
  template <bool to_root>
  void hand_down(const Body& body, Articulated<T>& I);
  void accelerate_body(Body& body) const;
  void add_joint_acceleration(Body& body, const T& a) const;
  void hand_down_composite(const Body& body);
  void unit_force(const Body& body, Vec3<T>& moment, Vec3<T>& force) const;
  void carry_force(const Body& body, Vec3<T>& moment, Vec3<T>& force) const;
  Body& parent_of(const Body& body) { return bodies_[body.mount.parent]; }
  const Body& parent_of(const Body& body) const { return bodies_[body.mount.parent]; }

  std::vector<Body> bodies_;
  std::vector<Joint> joints_;  ///< of the robot, for poses
};

}  // namespace lacuna

#include "backends/featherstone/tree_impl.h"
