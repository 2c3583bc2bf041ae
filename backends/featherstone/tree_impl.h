// Definitions of tree.h; included by it only.
#pragma once

namespace lacuna {

template <class T>
Tree<T>::Tree(const Robot& robot) : bodies_(static_cast<std::size_t>(robot.dof())) {
  for (int i = 0; i < robot.dof(); ++i) {
    const Joint& joint = robot.joints()[static_cast<std::size_t>(i)];
    Body& body = bodies_[static_cast<std::size_t>(i)];
    body.parent = joint.parent;
    body.prismatic = joint.prismatic();
    body.align = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), joint.axis).toRotationMatrix();
    const Eigen::Matrix3d parent_align =
        joint.parent < 0 ? Eigen::Matrix3d::Identity().eval() : bodies_[static_cast<std::size_t>(joint.parent)].align;
    body.rest = (parent_align.transpose() * joint.origin.linear() * body.align).transpose();
    body.place = parent_align.transpose() * joint.origin.translation();
    for (int k = 0; k < kLanes<T>; ++k) set_inertial(i, k, robot.body_inertial(i));
  }
  for (int k = 0; k < kLanes<T>; ++k) set_gravity(k, {0.0, 0.0, -9.81});
}

template <class T>
void Tree<T>::set_inertial(int index, int k, const Inertial& inertial) {
  Body& body = bodies_[static_cast<std::size_t>(index)];
  const Eigen::Vector3d c = body.align.transpose() * inertial.com;
  const Eigen::Matrix3d about_com = body.align.transpose() * inertial.inertia * body.align;
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
  set_lane(bodies_[static_cast<std::size_t>(joint)].armature, k, inertia);
}

template <class T>
void Tree<T>::set_gravity(int k, const Eigen::Vector3d& gravity) {
  set_lane(gravity_.x, k, gravity.x());
  set_lane(gravity_.y, k, gravity.y());
  set_lane(gravity_.z, k, gravity.z());
}

template <class T>
void Tree<T>::place_body(Body& body, const T& q) {
  const Mat3<T> rest = mat3<T>(body.rest);
  body.origin = vec3<T>(body.place);
  if (body.prismatic) {
    body.from_parent = rest;
    body.origin += q * rest.r2;
    return;
  }
  T s, c;
  sincos(q, s, c);
  body.from_parent = {c * rest.r0 + s * rest.r1, c * rest.r1 - s * rest.r0, rest.r2};
}

/// Velocity of the body, velocity-product terms, and the bias force v x* (I v).
template <class T>
void Tree<T>::move_body(Body& body, const T& v) {
  if (body.parent < 0) {
    body.omega = {};
    body.vel = {};
  } else {
    const Body& parent = bodies_[static_cast<std::size_t>(body.parent)];
    body.omega = body.from_parent * parent.omega;
    body.vel = body.from_parent * (parent.vel + cross(parent.omega, body.origin));
  }
  if (body.prismatic) {
    body.vel.z = body.vel.z + v;
    body.bias_ang = {};
    body.bias_lin = {v * body.omega.y, T(0.0) - v * body.omega.x, T(0.0)};
  } else {
    body.omega.z = body.omega.z + v;
    body.bias_ang = {v * body.omega.y, T(0.0) - v * body.omega.x, T(0.0)};
    body.bias_lin = {v * body.vel.y, T(0.0) - v * body.vel.x, T(0.0)};
  }
  const BodyMass<T>& m = body.mass;
  const Vec3<T> angular = m.inertia * body.omega + cross(m.moment, body.vel);
  const Vec3<T> linear = m.mass * body.vel + cross(body.omega, m.moment);
  body.moment = cross(body.omega, angular) + cross(body.vel, linear);
  body.force = cross(body.omega, linear);
}

template <class T>
void Tree<T>::eliminate_joint(Body& body, const T& tau, const T& free) {
  if (body.prismatic) {
    body.u_ang = {body.B.r0.z, body.B.r1.z, body.B.r2.z};
    body.u_lin = {body.C.xz, body.C.yz, body.C.zz};
    body.d_inv = free / (body.C.zz + body.armature);
    body.u = tau - body.force.z;
  } else {
    body.u_ang = {body.A.xz, body.A.yz, body.A.zz};
    body.u_lin = body.B.r2;
    body.d_inv = free / (body.A.zz + body.armature);
    body.u = tau - body.moment.z;
  }
}

template <class T>
void Tree<T>::add_to_parent(const Body& body, Body& parent) {
  const Sym3<T> A = minus_outer(body.A, body.u_ang, body.d_inv);
  const Mat3<T> B = minus_outer(body.B, body.u_ang, body.u_lin, body.d_inv);
  const Sym3<T> C = minus_outer(body.C, body.u_lin, body.d_inv);
  const T drive = body.d_inv * body.u;
  const Vec3<T> moment = body.moment + (A * body.bias_ang + B * body.bias_lin) + drive * body.u_ang;
  const Vec3<T> force = body.force + (transposed_times(B, body.bias_ang) + C * body.bias_lin) + drive * body.u_lin;

  // Turn into the parent's axes, then shift the reference point by r: A' = A + [r]B^T - B'[r], B' = B + [r]C.
  const Mat3<T>& e = body.from_parent;
  const Vec3<T>& r = body.origin;
  const Sym3<T> c = rotated(e, C);
  const Mat3<T> b = rotated(e, B);
  const Mat3<T> b_shifted = b + cross_times(r, full(c));
  const Mat3<T> left = cross_times(r, transpose(b));
  const Mat3<T> right = times_cross(b_shifted, r);
  parent.A += rotated(e, A) + symmetric(Mat3<T>{left.r0 - right.r0, left.r1 - right.r1, left.r2 - right.r2});
  parent.B += b_shifted;
  parent.C += c;
  const Vec3<T> f = transposed_times(e, force);
  parent.moment += transposed_times(e, moment) + cross(r, f);
  parent.force += f;
}

/// Acceleration of the body without its joint's own: the parent's, carried over, plus the velocity products.
template <class T>
void Tree<T>::accelerate_body(Body& body, Vec3<T>& alpha, Vec3<T>& acc) const {
  if (body.parent < 0) {
    alpha = body.bias_ang;
    acc = body.from_parent * (T(-1.0) * gravity_) + body.bias_lin;
    return;
  }
  const Body& parent = bodies_[static_cast<std::size_t>(body.parent)];
  alpha = body.from_parent * parent.alpha + body.bias_ang;
  acc = body.from_parent * (parent.acc + cross(parent.alpha, body.origin)) + body.bias_lin;
}

template <class T>
void Tree<T>::forward_dynamics(const T* q, const T* v, const T* tau, const T* free, T* a, T* imbalance) {
  const std::size_t n = bodies_.size();
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    place_body(body, q[i]);
    move_body(body, v[i]);
    const BodyMass<T>& m = body.mass;
    const T zero(0.0);
    body.A = m.inertia;
    body.B = {{zero, zero - m.moment.z, m.moment.y},
              {m.moment.z, zero, zero - m.moment.x},
              {zero - m.moment.y, m.moment.x, zero}};
    body.C = {m.mass, zero, zero, m.mass, zero, m.mass};
  }
  for (std::size_t i = n; i-- > 0;) {
    eliminate_joint(bodies_[i], tau[i], free[i]);
    if (bodies_[i].parent >= 0) add_to_parent(bodies_[i], bodies_[static_cast<std::size_t>(bodies_[i].parent)]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    accelerate_body(body, body.alpha, body.acc);
    imbalance[i] = body.u - (dot(body.u_ang, body.alpha) + dot(body.u_lin, body.acc));
    a[i] = imbalance[i] * body.d_inv;
    (body.prismatic ? body.acc.z : body.alpha.z) = (body.prismatic ? body.acc.z : body.alpha.z) + a[i];
  }
}

template <class T>
void Tree<T>::inverse_dynamics(const T* q, const T* v, const T* a, T* tau) {
  const std::size_t n = bodies_.size();
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    place_body(body, q[i]);
    move_body(body, v[i]);
    accelerate_body(body, body.alpha, body.acc);
    (body.prismatic ? body.acc.z : body.alpha.z) = (body.prismatic ? body.acc.z : body.alpha.z) + a[i];
    const BodyMass<T>& m = body.mass;
    body.moment += m.inertia * body.alpha + cross(m.moment, body.acc);
    body.force += m.mass * body.acc + cross(body.alpha, m.moment);
  }
  for (std::size_t i = n; i-- > 0;) {
    const Body& body = bodies_[i];
    tau[i] = (body.prismatic ? body.force.z : body.moment.z) + body.armature * a[i];
    if (body.parent < 0) continue;
    Body& parent = bodies_[static_cast<std::size_t>(body.parent)];
    const Vec3<T> f = transposed_times(body.from_parent, body.force);
    parent.force += f;
    parent.moment += transposed_times(body.from_parent, body.moment) + cross(body.origin, f);
  }
}

template <class T>
void Tree<T>::mass_matrix(const T* q, T* mass) {
  const std::size_t n = bodies_.size();
  std::fill(mass, mass + n * n, T(0.0));
  for (std::size_t i = 0; i < n; ++i) {
    Body& body = bodies_[i];
    place_body(body, q[i]);
    body.A = body.mass.inertia;
    body.force = body.mass.moment;  // the composite's first moment and mass stand in B and C
    body.u = body.mass.mass;
  }
  for (std::size_t i = n; i-- > 0;) {
    const Body& body = bodies_[i];
    // Force that gives the composite a unit acceleration of joint i, then carried down to the root.
    Vec3<T> moment = body.prismatic ? Vec3<T>{body.force.y, T(0.0) - body.force.x, T(0.0)}
                                    : Vec3<T>{body.A.xz, body.A.yz, body.A.zz};
    Vec3<T> force =
        body.prismatic ? Vec3<T>{T(0.0), T(0.0), body.u} : Vec3<T>{T(0.0) - body.force.y, body.force.x, T(0.0)};
    mass[i * n + i] = (body.prismatic ? force.z : moment.z) + body.armature;
    for (std::size_t j = i; bodies_[j].parent >= 0;) {
      force = transposed_times(bodies_[j].from_parent, force);
      moment = transposed_times(bodies_[j].from_parent, moment) + cross(bodies_[j].origin, force);
      j = static_cast<std::size_t>(bodies_[j].parent);
      mass[i * n + j] = mass[j * n + i] = bodies_[j].prismatic ? force.z : moment.z;
    }
    if (body.parent < 0) continue;
    Body& parent = bodies_[static_cast<std::size_t>(body.parent)];
    const Vec3<T>& r = body.origin;
    const Vec3<T> h = transposed_times(body.from_parent, body.force);
    const T rh = dot(r, h), rr = dot(r, r), two(2.0);
    Sym3<T> I = rotated(body.from_parent, body.A);
    // Parallel axes: I' = I + 2 (r.h) 1 - r h^T - h r^T + m (r.r 1 - r r^T)
    const T diagonal = two * rh + body.u * rr;
    const Vec3<T> mr = body.u * r;
    I.xx = I.xx + diagonal - two * r.x * h.x - mr.x * r.x;
    I.yy = I.yy + diagonal - two * r.y * h.y - mr.y * r.y;
    I.zz = I.zz + diagonal - two * r.z * h.z - mr.z * r.z;
    I.xy = I.xy - r.x * h.y - h.x * r.y - mr.x * r.y;
    I.xz = I.xz - r.x * h.z - h.x * r.z - mr.x * r.z;
    I.yz = I.yz - r.y * h.z - h.y * r.z - mr.y * r.z;
    parent.A += I;
    parent.force += h + mr;
    parent.u = parent.u + body.u;
  }
}

template <class T>
void Tree<T>::body_poses(const T* q, std::vector<Eigen::Isometry3d>& poses) const requires std::same_as<T, double> {
  poses.resize(bodies_.size());
  std::vector<Eigen::Isometry3d> kernel(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
    step.linear() = body.rest.transpose();
    step.translation() = body.place;
    if (body.prismatic) {
      step.translate(Eigen::Vector3d(0.0, 0.0, q[i]));
    } else {
      step.rotate(Eigen::AngleAxisd(q[i], Eigen::Vector3d::UnitZ()));
    }
    kernel[i] = body.parent < 0 ? step : kernel[static_cast<std::size_t>(body.parent)] * step;
    poses[i] = kernel[i];
    poses[i].linear() = kernel[i].linear() * body.align.transpose();
  }
}

}  // namespace lacuna
