// Our own rigid-body dynamics: Featherstone's recursive algorithms over any scalar type.
//
// Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008: RNEA (table 5.1), CRBA (6.2), ABA (7.1), with spatial
// vectors kept as two three-vectors. Each body's frame is turned once, at construction, so that its joint axis is
// local z: motion subspaces become unit vectors, U and D become a column of the articulated inertia.
//
// Structure (tree, placements) is shared by all lanes; mass properties and gravity may differ from lane to lane.
// No allocation after construction. Not shared between threads.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "backends/featherstone/spatial.h"
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
  /// Inertia reflected to a joint by what turns with its motor, kg m^2 (kg): added to that joint's own acceleration only.
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

  const BodyMass<T>& body_mass(int body) const { return bodies_[static_cast<std::size_t>(body)].mass; }

 private:
  struct Body {
    int parent = -1;
    bool prismatic = false;
    Eigen::Matrix3d align;  ///< URDF body frame <- kernel frame
    Eigen::Matrix3d rest;   ///< kernel frame of this body <- of the parent, at q = 0
    Eigen::Vector3d place;  ///< m, joint origin in the parent's kernel frame
    BodyMass<T> mass;
    T armature = T(0.0);
    // Scratch of one evaluation, all in this body's kernel frame:
    Mat3<T> from_parent;         ///< rotation, this <- parent
    Vec3<T> origin;              ///< m, this origin in the parent's frame
    Vec3<T> omega, vel;          ///< rad/s, m/s of the origin
    Vec3<T> bias_ang, bias_lin;  ///< velocity-product acceleration of the joint
    Vec3<T> alpha, acc;          ///< spatial acceleration
    Sym3<T> A, C;                ///< articulated inertia [A B; B^T C]
    Mat3<T> B;
    Vec3<T> moment, force;  ///< bias force, then transmitted force
    Vec3<T> u_ang, u_lin;   ///< U = inertia times the joint's unit motion
    T d_inv = T(0.0), u = T(0.0);
  };

  void place_body(Body& body, const T& q);
  void move_body(Body& body, const T& v);
  void eliminate_joint(Body& body, const T& tau, const T& free);
  void add_to_parent(const Body& body, Body& parent);
  void accelerate_body(Body& body, Vec3<T>& alpha, Vec3<T>& acc) const;

  std::vector<Body> bodies_;
  Vec3<T> gravity_;
};

}  // namespace lacuna

#include "backends/featherstone/tree_impl.h"
