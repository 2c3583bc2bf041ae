// Definitions of tree.h; included by it only.
#pragma once

namespace lacuna {

template <class T>
Tree<T>::Tree(const Robot& robot) : bodies_(robot.dof()), joints_(robot.joints()) {
  const std::vector<Mount> mounts = mounts_of(robot);
  for (std::size_t i = bodies_.size(); i-- > 0;) {
    Body& body = bodies_[i];
    body.mount = mounts[i];
    body.slide = T(body.mount.shift.z());
    if (body.mount.prismatic) {
      body.c = T(std::cos(body.mount.offset));
      body.s = T(std::sin(body.mount.offset));
    }
    if (body.mount.parent < 0) continue;
    body.last = parent_of(body).leaf;
    parent_of(body).leaf = false;
  }
  for (int k = 0; k < kLanes<T>; ++k) {
    for (int i = 0; i < robot.dof(); ++i) set_inertial(i, k, robot.body_inertial(i));
    set_gravity(k, {0.0, 0.0, -9.81});
  }
}

template <class T>
void Tree<T>::set_inertial(int index, int k, const Inertial& inertial) {
  Body& body = bodies_[index];
  const Eigen::Matrix3d& align = body.mount.align;
  const Eigen::Vector3d c = align.transpose() * (inertial.com - body.mount.origin);
  const Eigen::Matrix3d about_com = align.transpose() * inertial.inertia * align;
  const Eigen::Matrix3d I =
      about_com + inertial.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  set_lane(body.mass.mass, k, inertial.mass);
  set_lane(body.mass.moment.x, k, inertial.mass * c.x());
  set_lane(body.mass.moment.y, k, inertial.mass * c.y());
  set_lane(body.mass.moment.z, k, inertial.mass * c.z());
  set_lane(body.mass.inertia.xx, k, I(0, 0));
  set_lane(body.mass.inertia.xy, k, I(0, 1));
  set_lane(body.mass.inertia.xz, k, I(0, 2));
  set_lane(body.mass.inertia.yy, k, I(1, 1));
  set_lane(body.mass.inertia.yz, k, I(1, 2));
  set_lane(body.mass.inertia.zz, k, I(2, 2));
}

template <class T>
void Tree<T>::set_armature(int joint, int k, double inertia) {
  set_lane(bodies_[joint].armature, k, inertia);
}

template <class T>
void Tree<T>::set_gravity(int k, const Eigen::Vector3d& gravity) {
  for (Body& body : bodies_) {
    if (body.mount.parent >= 0) continue;
    const Eigen::Vector3d fall = body.mount.to_rest * -gravity;
    set_lane(body.fall.x, k, fall.x());
    set_lane(body.fall.y, k, fall.y());
    set_lane(body.fall.z, k, fall.z());
  }
}

template <class T>
[[gnu::always_inline]] inline void Tree<T>::place_body(Body& body, const T& q) {
  if (body.mount.prismatic) {
    body.slide = T(body.mount.shift.z()) + q;
  } else {
    sincos(q + T(body.mount.offset), body.s, body.c);
  }
}

/// Angular velocity, velocity-product accelerations, and the body's bias force.
template <class T>
[[gnu::always_inline]] inline void Tree<T>::move_body(Body& body, const T& v) {
  if (body.mount.parent < 0) {
    // A root turns or slides along one axis: its bias force has nothing in the direction that the joint leaves free.
    body.omega = {T(0.0), T(0.0), body.mount.prismatic ? T(0.0) : v};
    body.moment = body.force = {};
    return;
  }
  const Vec3<T> omega = to_rest(body.mount, parent_of(body).omega);
  const Vec3<T> across{v * omega.y, T(0.0) - v * omega.x, T(0.0)};  // omega x (0, 0, v)
  if (body.mount.shifts) body.bias_lin = cross(omega, cross_shift(body.mount, omega, body.slide));
  if (body.mount.prismatic) {
    body.bias_lin += T(2.0) * across;
  } else {
    body.bias_ang = across;
  }
  body.omega = turned_back_z(omega, body.c, body.s);
  if (!body.mount.prismatic) body.omega.z = body.omega.z + v;
  body.moment = cross(body.omega, body.mass.inertia * body.omega);
  body.force = cross(body.omega, cross(body.omega, body.mass.moment));
}

/// As gathered() and solve_joint() of a root, which needs no more than its joint's row.
template <class T>
[[gnu::always_inline]] inline void Tree<T>::solve_root(Body& body, const T& tau, const T& free) {
  const BodyMass<T>& m = body.mass;
  const Articulated<T>& I = body.carried;
  T d = body.armature;
  if (body.mount.prismatic) {
    body.u_lin = {I.C.xz, I.C.yz, I.C.zz + m.mass};
    d = d + body.u_lin.z;
    body.u = tau - I.force.z;
  } else {
    body.u_lin = {I.B.r2.x - m.moment.y, I.B.r2.y + m.moment.x, I.B.r2.z};
    d = d + (I.A.zz + m.inertia.zz);
    body.u = tau - I.moment.z;
  }
  body.d_inv = free / d;
}

/// The body's own inertia and bias force with those that its children have handed down.
template <class T>
[[gnu::always_inline]] inline Articulated<T> Tree<T>::gathered(const Body& body) const {
  const BodyMass<T>& m = body.mass;
  const Vec3<T>& h = m.moment;
  const T zero(0.0);
  if (body.leaf) {
    return {m.inertia,
            {m.mass, zero, zero, m.mass, zero, m.mass},
            {{zero, zero - h.z, h.y}, {h.z, zero, zero - h.x}, {zero - h.y, h.x, zero}},
            body.moment,
            body.force};
  }
  Articulated<T> I = body.carried;
  I.A += m.inertia;
  I.C.xx = I.C.xx + m.mass, I.C.yy = I.C.yy + m.mass, I.C.zz = I.C.zz + m.mass;
  I.B.r0.y = I.B.r0.y - h.z, I.B.r0.z = I.B.r0.z + h.y;
  I.B.r1.x = I.B.r1.x + h.z, I.B.r1.z = I.B.r1.z - h.x;
  I.B.r2.x = I.B.r2.x - h.y, I.B.r2.y = I.B.r2.y + h.x;
  I.moment += body.moment;
  I.force += body.force;
  return I;
}

template <class T>
[[gnu::always_inline]] inline void Tree<T>::solve_joint(Body& body, const Articulated<T>& I, const T& tau,
                                                        const T& free) {
  if (body.mount.prismatic) {
    body.u_ang = {I.B.r0.z, I.B.r1.z, I.B.r2.z};
    body.u_lin = {I.C.xz, I.C.yz, I.C.zz};
    body.d_inv = free / (I.C.zz + body.armature);
    body.u = tau - I.force.z;
  } else {
    body.u_ang = {I.A.xz, I.A.yz, I.A.zz};
    body.u_lin = I.B.r2;
    body.d_inv = free / (I.A.zz + body.armature);
    body.u = tau - I.moment.z;
  }
  body.kept = (T(1.0) - free) + body.armature * body.d_inv;
}

/// What the joint passes on of I, turned into the rest frame's axes; joint about z. Where it is free and has no
/// armature nothing of U is kept: a row and a column of the inertia are zero.
template <class T>
[[gnu::always_inline]] inline void Tree<T>::reduce_revolute(const Body& body, Articulated<T>& I) const {
  const T &c = body.c, &s = body.s, x = body.d_inv * body.u_ang.x, y = body.d_inv * body.u_ang.y;
  const T axx = I.A.xx - x * body.u_ang.x, axy = I.A.xy - x * body.u_ang.y, ayy = I.A.yy - y * body.u_ang.y;
  const T p = c * axx - s * axy, q = c * axy - s * ayy;
  I.A.yy = s * (s * axx + c * axy) + c * (s * axy + c * ayy);
  I.A.xx = c * p - s * q;
  I.A.xy = s * p + c * q;
  const Vec3<T> bx = turned_z(I.B.r0 - x * body.u_lin, c, s), by = turned_z(I.B.r1 - y * body.u_lin, c, s);
  I.B.r0 = c * bx - s * by;
  I.B.r1 = s * bx + c * by;
  I.C = turned_z(minus_outer(I.C, body.u_lin, body.d_inv), c, s);
  if (any(body.kept != T(0.0))) {
    const Vec3<T> row = turned_z(body.kept * body.u_ang, c, s);
    I.A.xz = row.x, I.A.yz = row.y, I.A.zz = row.z;
    I.B.r2 = turned_z(body.kept * body.u_lin, c, s);
  } else {
    I.A.xz = I.A.yz = I.A.zz = T(0.0);
    I.B.r2 = {};
  }
}

/// The same; joint along z.
template <class T>
[[gnu::always_inline]] inline void Tree<T>::reduce_prismatic(const Body& body, Articulated<T>& I) const {
  I.A = turned_z(minus_outer(I.A, body.u_ang, body.d_inv), body.c, body.s);
  I.B = turned_z(minus_outer(I.B, body.u_ang, body.u_lin, body.d_inv), body.c, body.s);
  I.C = turned_z(minus_outer(I.C, body.u_lin, body.d_inv), body.c, body.s);
}

/// Adds to what the parent carries; of a root's share only the joint's own row is ever looked at.
template <class T>
template <bool to_root>
[[gnu::always_inline]] inline void Tree<T>::give(const Body& body, const Articulated<T>& I, Body& parent) const {
  Articulated<T>& sum = parent.carried;
  if constexpr (to_root) {
    if (body.last) sum = {};
    if (parent.mount.prismatic) {
      sum.C.xz = sum.C.xz + I.C.xz, sum.C.yz = sum.C.yz + I.C.yz, sum.C.zz = sum.C.zz + I.C.zz;
      sum.force.z = sum.force.z + I.force.z;
    } else {
      sum.A.zz = sum.A.zz + I.A.zz;
      sum.B.r2 += I.B.r2;
      sum.moment.z = sum.moment.z + I.moment.z;
    }
  } else if (body.last) {
    sum = I;
  } else {
    sum += I;
  }
}

/// What the body passes on to its parent: I reduced by the joint, its bias force with what moves the joint.
template <class T>
template <bool to_root>
[[gnu::always_inline]] inline void Tree<T>::hand_down(const Body& body, Articulated<T>& I) {
  const Mount& mount = body.mount;
  const T drive = body.d_inv * body.u;
  I.moment = turned_z(I.moment + drive * body.u_ang, body.c, body.s);
  I.force = turned_z(I.force + drive * body.u_lin, body.c, body.s);
  if (mount.prismatic) {
    reduce_prismatic(body, I);
  } else {
    reduce_revolute(body, I);
    const T &x = body.bias_ang.x, &y = body.bias_ang.y;
    I.moment += x * Vec3<T>{I.A.xx, I.A.xy, I.A.xz} + y * Vec3<T>{I.A.xy, I.A.yy, I.A.yz};
    I.force += x * I.B.r0 + y * I.B.r1;
  }
  if (mount.shifts) {
    I.moment += I.B * body.bias_lin;
    I.force += I.C * body.bias_lin;
  }
  if (mount.shift.x() != 0.0) shift_x(I, T(mount.shift.x()));
  if (mount.shift.y() != 0.0) shift_y(I, T(mount.shift.y()));
  if (mount.prismatic || mount.shift.z() != 0.0) shift_z(I, body.slide);
  if (mount.swings || mount.tilt == Tilt::any) {
    I = turned_to_parent(mount, I);
  } else if (mount.tilt == Tilt::quarter) {
    I = quarter_x(I);
  }
  give<to_root>(body, I, parent_of(body));
}

/// Acceleration of the body without its joint's own: the parent's, carried over, plus the velocity products.
template <class T>
[[gnu::always_inline]] inline void Tree<T>::accelerate_body(Body& body) const {
  if (body.mount.parent < 0) {
    body.alpha = {};
    body.acc = turned_back_z(body.fall, body.c, body.s);
    return;
  }
  const Body& parent = parent_of(body);
  Vec3<T> alpha = to_rest(body.mount, parent.alpha), acc = to_rest(body.mount, parent.acc);
  if (body.mount.shifts) acc += cross_shift(body.mount, alpha, body.slide) + body.bias_lin;
  alpha.x = alpha.x + body.bias_ang.x;
  alpha.y = alpha.y + body.bias_ang.y;
  body.alpha = turned_back_z(alpha, body.c, body.s);
  body.acc = turned_back_z(acc, body.c, body.s);
}

template <class T>
[[gnu::always_inline]] inline void Tree<T>::add_joint_acceleration(Body& body, const T& a) const {
  T& own = body.mount.prismatic ? body.acc.z : body.alpha.z;
  own = own + a;
}

template <class T>
void Tree<T>::forward_dynamics(const T* q, const T* v, const T* tau, const T* free, T* a, T* imbalance) {
  const std::size_t n = bodies_.size();
  for (std::size_t i = 0; i < n; ++i) {
    place_body(bodies_[i], q[i]);
    move_body(bodies_[i], v[i]);
  }
  for (std::size_t i = n; i-- > 0;) {
    Body& body = bodies_[i];
    if (body.mount.parent < 0) {
      solve_root(body, tau[i], free[i]);
      continue;
    }
    Articulated<T> I = gathered(body);
    solve_joint(body, I, tau[i], free[i]);
    if (parent_of(body).mount.parent < 0) {
      hand_down<true>(body, I);
    } else {
      hand_down<false>(body, I);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    accelerate_body(body);
    imbalance[i] = body.u - (dot(body.u_ang, body.alpha) + dot(body.u_lin, body.acc));
    a[i] = imbalance[i] * body.d_inv;
    add_joint_acceleration(body, a[i]);
  }
}

/// A force on the body about its origin becomes one about the parent's origin, in the parent's axes.
template <class T>
void Tree<T>::carry_force(const Body& body, Vec3<T>& moment, Vec3<T>& force) const {
  const Vec3<T> f = turned_z(force, body.c, body.s);
  const Vec3<T> m = turned_z(moment, body.c, body.s) - cross_shift(body.mount, f, body.slide);
  force = to_parent(body.mount, f);
  moment = to_parent(body.mount, m);
}

template <class T>
void Tree<T>::inverse_dynamics(const T* q, const T* v, const T* a, T* tau) {
  const std::size_t n = bodies_.size();
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    place_body(body, q[i]);
    move_body(body, v[i]);
    accelerate_body(body);
    add_joint_acceleration(body, a[i]);
    const BodyMass<T>& m = body.mass;
    body.moment += m.inertia * body.alpha + cross(m.moment, body.acc);
    body.force += m.mass * body.acc + cross(body.alpha, m.moment);
  }
  for (std::size_t i = n; i-- > 0;) {
    Body& body = bodies_[i];
    tau[i] = (body.mount.prismatic ? body.force.z : body.moment.z) + body.armature * a[i];
    if (body.mount.parent < 0) continue;
    carry_force(body, body.moment, body.force);
    parent_of(body).force += body.force;
    parent_of(body).moment += body.moment;
  }
}

/// Force that gives the composite from this body outwards a unit acceleration of its joint.
template <class T>
void Tree<T>::unit_force(const Body& body, Vec3<T>& moment, Vec3<T>& force) const {
  const T zero(0.0);
  if (body.mount.prismatic) {
    moment = {body.first.y, zero - body.first.x, zero};
    force = {zero, zero, body.total};
  } else {
    moment = {body.second.xz, body.second.yz, body.second.zz};
    force = {zero - body.first.y, body.first.x, zero};
  }
}

/// Adds the composite to the parent's. Parallel axes: I' = I + 2 (r.h) 1 - r h^T - h r^T + m (r.r 1 - r r^T).
template <class T>
void Tree<T>::hand_down_composite(const Body& body) {
  const Vec3<T> r{T(body.mount.shift.x()), T(body.mount.shift.y()), body.slide};
  const Vec3<T> h = turned_z(body.first, body.c, body.s), mr = body.total * r;
  const T two(2.0), diagonal = two * dot(r, h) + dot(r, mr);
  Sym3<T> I = turned_z(body.second, body.c, body.s);
  I.xx = I.xx + diagonal - two * r.x * h.x - mr.x * r.x;
  I.yy = I.yy + diagonal - two * r.y * h.y - mr.y * r.y;
  I.zz = I.zz + diagonal - two * r.z * h.z - mr.z * r.z;
  I.xy = I.xy - r.x * h.y - h.x * r.y - mr.x * r.y;
  I.xz = I.xz - r.x * h.z - h.x * r.z - mr.x * r.z;
  I.yz = I.yz - r.y * h.z - h.y * r.z - mr.y * r.z;
  Body& parent = parent_of(body);
  parent.second += to_parent(body.mount, I);
  parent.first += to_parent(body.mount, h + mr);
  parent.total = parent.total + body.total;
}

template <class T>
void Tree<T>::mass_matrix(const T* q, T* mass) {
  const std::size_t n = bodies_.size();
  std::fill(mass, mass + n * n, T(0.0));
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    place_body(body, q[i]);
    body.total = body.mass.mass;
    body.first = body.mass.moment;
    body.second = body.mass.inertia;
  }
  for (std::size_t i = n; i-- > 0;) {
    Vec3<T> moment, force;
    unit_force(bodies_[i], moment, force);
    mass[i * n + i] = (bodies_[i].mount.prismatic ? force.z : moment.z) + bodies_[i].armature;
    for (std::size_t j = i; bodies_[j].mount.parent >= 0;) {
      carry_force(bodies_[j], moment, force);
      j = static_cast<std::size_t>(bodies_[j].mount.parent);
      mass[i * n + j] = mass[j * n + i] = bodies_[j].mount.prismatic ? force.z : moment.z;
    }
    if (bodies_[i].mount.parent >= 0) hand_down_composite(bodies_[i]);
  }
}

template <class T>
void Tree<T>::body_poses(const T* q, std::vector<Eigen::Isometry3d>& poses) const requires std::same_as<T, double> {
  poses.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Joint& joint = joints_[i];
    Eigen::Isometry3d pose = joint.parent < 0 ? joint.origin : poses[joint.parent] * joint.origin;
    if (joint.prismatic()) {
      pose.translate(q[i] * joint.axis);
    } else {
      pose.rotate(Eigen::AngleAxisd(q[i], joint.axis));
    }
    poses[i] = pose;
  }
}

}  // namespace lacuna
