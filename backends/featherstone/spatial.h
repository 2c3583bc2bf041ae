// Three-vectors and 3x3 blocks over any scalar type: all the algebra that the tree kernels need.
// (Scalars are initialised as T(0.0), never as T{0.0}: to a pack the braces are a list of lanes.)
#pragma once

#include <Eigen/Core>

#include "backends/featherstone/scalar.h"

namespace lacuna {

template <class T>
struct Vec3 {
  T x = T(0.0), y = T(0.0), z = T(0.0);

  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(const T& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
  Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
};

template <class T>
Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// General 3x3, by rows.
template <class T>
struct Mat3 {
  Vec3<T> r0, r1, r2;

  friend Mat3 operator+(const Mat3& a, const Mat3& b) { return {a.r0 + b.r0, a.r1 + b.r1, a.r2 + b.r2}; }
  Mat3& operator+=(const Mat3& b) { return *this = *this + b; }
};

template <class T>
Vec3<T> operator*(const Mat3<T>& m, const Vec3<T>& a) {
  return {dot(m.r0, a), dot(m.r1, a), dot(m.r2, a)};
}
/// m^T a
template <class T>
Vec3<T> transposed_times(const Mat3<T>& m, const Vec3<T>& a) {
  return a.x * m.r0 + a.y * m.r1 + a.z * m.r2;
}

/// Symmetric 3x3.
template <class T>
struct Sym3 {
  T xx = T(0.0), xy = T(0.0), xz = T(0.0), yy = T(0.0), yz = T(0.0), zz = T(0.0);

  friend Sym3 operator+(const Sym3& a, const Sym3& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
  }
  Sym3& operator+=(const Sym3& b) { return *this = *this + b; }
};

template <class T>
Vec3<T> operator*(const Sym3<T>& m, const Vec3<T>& a) {
  return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
          m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
/// m - s a a^T
template <class T>
Sym3<T> minus_outer(const Sym3<T>& m, const Vec3<T>& a, const T& s) {
  const Vec3<T> b = s * a;
  return {m.xx - b.x * a.x, m.xy - b.x * a.y, m.xz - b.x * a.z, m.yy - b.y * a.y, m.yz - b.y * a.z, m.zz - b.z * a.z};
}
/// m - s a b^T
template <class T>
Mat3<T> minus_outer(const Mat3<T>& m, const Vec3<T>& a, const Vec3<T>& b, const T& s) {
  const Vec3<T> c = s * a;
  return {m.r0 - c.x * b, m.r1 - c.y * b, m.r2 - c.z * b};
}

template <class T>
Vec3<T> vec3(const Eigen::Vector3d& a) {
  return {T(a.x()), T(a.y()), T(a.z())};
}

}  // namespace lacuna
