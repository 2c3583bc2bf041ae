// Articulated-body inertia with its bias force, and the moves along a mount (mount.h) one coordinate axis at a time.
//
// [A B; B^T C] maps (angular, linear) acceleration of a frame's origin to (moment, force) about it. Turns take
// coordinates from a frame into the one that it is turned against; c, s are the turn's cosine and sine.
#pragma once

#include "backends/featherstone/mount.h"
#include "backends/featherstone/spatial.h"

namespace lacuna {

// ---- turns of vectors: about z, about x, and a quarter about x ----
template <class T>
[[gnu::always_inline]] inline Vec3<T> turned_z(const Vec3<T>& a, const T& c, const T& s) {
  return {c * a.x - s * a.y, s * a.x + c * a.y, a.z};
}
template <class T>
[[gnu::always_inline]] inline Vec3<T> turned_back_z(const Vec3<T>& a, const T& c, const T& s) {
  return {c * a.x + s * a.y, c * a.y - s * a.x, a.z};
}
template <class T>
[[gnu::always_inline]] inline Vec3<T> turned_x(const Vec3<T>& a, const T& c, const T& s) {
  return {a.x, c * a.y - s * a.z, s * a.y + c * a.z};
}
template <class T>
[[gnu::always_inline]] inline Vec3<T> turned_back_x(const Vec3<T>& a, const T& c, const T& s) {
  return {a.x, c * a.y + s * a.z, c * a.z - s * a.y};
}
template <class T>
Vec3<T> quarter_x(const Vec3<T>& a) {
  return {a.x, T(0.0) - a.z, a.y};
}
template <class T>
Vec3<T> quarter_back_x(const Vec3<T>& a) {
  return {a.x, a.z, T(0.0) - a.y};
}

// ---- turns of inertias ----
template <class T>
[[gnu::always_inline]] inline Sym3<T> turned_z(const Sym3<T>& m, const T& c, const T& s) {
  const T a = c * m.xx - s * m.xy, b = c * m.xy - s * m.yy, d = s * m.xx + c * m.xy, e = s * m.xy + c * m.yy;
  return {c * a - s * b, s * a + c * b, c * m.xz - s * m.yz, s * d + c * e, s * m.xz + c * m.yz, m.zz};
}
template <class T>
[[gnu::always_inline]] inline Sym3<T> turned_x(const Sym3<T>& m, const T& c, const T& s) {
  const T a = c * m.yy - s * m.yz, b = c * m.yz - s * m.zz, d = s * m.yy + c * m.yz, e = s * m.yz + c * m.zz;
  return {m.xx, c * m.xy - s * m.xz, s * m.xy + c * m.xz, c * a - s * b, s * a + c * b, s * d + c * e};
}
template <class T>
Sym3<T> quarter_x(const Sym3<T>& m) {
  return {m.xx, T(0.0) - m.xz, m.xy, m.zz, T(0.0) - m.yz, m.yy};
}
template <class T>
[[gnu::always_inline]] inline Mat3<T> turned_z(const Mat3<T>& m, const T& c, const T& s) {
  const Vec3<T> a = turned_z(m.r0, c, s), b = turned_z(m.r1, c, s);
  return {c * a - s * b, s * a + c * b, turned_z(m.r2, c, s)};
}
template <class T>
[[gnu::always_inline]] inline Mat3<T> turned_x(const Mat3<T>& m, const T& c, const T& s) {
  const Vec3<T> a = turned_x(m.r1, c, s), b = turned_x(m.r2, c, s);
  return {turned_x(m.r0, c, s), c * a - s * b, s * a + c * b};
}
template <class T>
Mat3<T> quarter_x(const Mat3<T>& m) {
  return {quarter_x(m.r0), T(-1.0) * quarter_x(m.r2), quarter_x(m.r1)};
}

template <class T>
struct Articulated {
  Sym3<T> A, C;           ///< kg m^2; kg
  Mat3<T> B;              ///< kg m
  Vec3<T> moment, force;  ///< N m; N

  Articulated& operator+=(const Articulated& b) {
    A += b.A;
    B += b.B;
    C += b.C;
    moment += b.moment;
    force += b.force;
    return *this;
  }
};

template <class T>
[[gnu::always_inline]] inline Articulated<T> quarter_x(const Articulated<T>& I) {
  return {quarter_x(I.A), quarter_x(I.C), quarter_x(I.B), quarter_x(I.moment), quarter_x(I.force)};
}

/// Reference point moved from (a, 0, 0) to the origin: A' = A + [r] B^T - B' [r], B' = B + [r] C.
template <class T>
[[gnu::always_inline]] inline void shift_x(Articulated<T>& I, const T& a) {
  auto& [A, C, B, moment, force] = I;
  const T yz = B.r1.z, zy = B.r2.y, zz = B.r2.z;
  B.r1 = B.r1 - a * Vec3<T>{C.xz, C.yz, C.zz};
  B.r2 = B.r2 + a * Vec3<T>{C.xy, C.yy, C.yz};
  A.xy = A.xy - a * B.r0.z;
  A.xz = A.xz + a * B.r0.y;
  A.yy = A.yy - a * (yz + B.r1.z);
  A.yz = A.yz + a * (B.r1.y - zz);
  A.zz = A.zz + a * (zy + B.r2.y);
  moment.y = moment.y - a * force.z;
  moment.z = moment.z + a * force.y;
}
/// The same from (0, b, 0).
template <class T>
[[gnu::always_inline]] inline void shift_y(Articulated<T>& I, const T& b) {
  auto& [A, C, B, moment, force] = I;
  const T xz = B.r0.z, zx = B.r2.x, zz = B.r2.z;
  B.r0 = B.r0 + b * Vec3<T>{C.xz, C.yz, C.zz};
  B.r2 = B.r2 - b * Vec3<T>{C.xx, C.xy, C.xz};
  A.xx = A.xx + b * (xz + B.r0.z);
  A.xy = A.xy + b * B.r1.z;
  A.xz = A.xz + b * (zz - B.r0.x);
  A.yz = A.yz - b * B.r1.x;
  A.zz = A.zz - b * (zx + B.r2.x);
  moment.x = moment.x + b * force.z;
  moment.z = moment.z - b * force.x;
}
/// The same from (0, 0, d).
template <class T>
[[gnu::always_inline]] inline void shift_z(Articulated<T>& I, const T& d) {
  auto& [A, C, B, moment, force] = I;
  const T xy = B.r0.y, yx = B.r1.x, yy = B.r1.y;
  B.r0 = B.r0 - d * Vec3<T>{C.xy, C.yy, C.yz};
  B.r1 = B.r1 + d * Vec3<T>{C.xx, C.xy, C.xz};
  A.xx = A.xx - d * (xy + B.r0.y);
  A.xy = A.xy + d * (B.r0.x - yy);
  A.xz = A.xz - d * B.r2.y;
  A.yy = A.yy + d * (yx + B.r1.x);
  A.yz = A.yz + d * B.r2.x;
  moment.x = moment.x - d * force.y;
  moment.y = moment.y + d * force.x;
}

// ---- along the fixed part of a mount ----

/// From the parent's frame to the rest frame.
template <class T>
Vec3<T> to_rest(const Mount& m, Vec3<T> a) {
  if (m.swings) a = turned_back_z(a, T(m.cos_swing), T(m.sin_swing));
  if (m.tilt == Tilt::none) return a;
  return m.tilt == Tilt::quarter ? quarter_back_x(a) : turned_back_x(a, T(m.cos_tilt), T(m.sin_tilt));
}
/// From the rest frame to the parent's: vectors and inertias.
template <class T, template <class> class Any>
Any<T> to_parent(const Mount& m, Any<T> a) {
  if (m.tilt == Tilt::quarter) a = quarter_x(a);
  if (m.tilt == Tilt::any) a = turned_x(a, T(m.cos_tilt), T(m.sin_tilt));
  return m.swings ? turned_z(a, T(m.cos_swing), T(m.sin_swing)) : a;
}
/// Any turn; kept out of line, for robots whose axes are neither parallel nor at right angles.
template <class T>
[[gnu::noinline]] Articulated<T> turned_to_parent(const Mount& m, Articulated<T> I) {
  return {to_parent(m, I.A), to_parent(m, I.C), to_parent(m, I.B), to_parent(m, I.moment), to_parent(m, I.force)};
}

/// a x r, r known to the mount apart from `slide` along z.
template <class T>
[[gnu::always_inline]] inline Vec3<T> cross_shift(const Mount& m, const Vec3<T>& a, const T& slide) {
  Vec3<T> out;
  if (m.shift.x() != 0.0) out.y = a.z * T(m.shift.x()), out.z = T(0.0) - a.y * T(m.shift.x());
  if (m.shift.y() != 0.0) out.x = T(0.0) - a.z * T(m.shift.y()), out.z = out.z + a.x * T(m.shift.y());
  if (m.prismatic || m.shift.z() != 0.0) {
    out.x = out.x + a.y * slide;
    out.y = out.y - a.x * slide;
  }
  return out;
}

}  // namespace lacuna
