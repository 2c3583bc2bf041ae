// A double whose multiplications and additions the compiler may fuse: a type of its own, so that kernels over it can be
// built for CPUs with FMA beside those over `double`, which stay as they are for every CPU.
#pragma once

#include <cmath>

#include "backends/featherstone/scalar.h"

namespace lacuna {

/// Laid out as a double; arrays of doubles may be read through it.
struct [[gnu::may_alias]] Fused {
  double x;

  Fused() = default;
  explicit Fused(double value) : x(value) {}
  friend Fused operator+(const Fused& a, const Fused& b) { return Fused(a.x + b.x); }
  friend Fused operator-(const Fused& a, const Fused& b) { return Fused(a.x - b.x); }
  friend Fused operator*(const Fused& a, const Fused& b) { return Fused(a.x * b.x); }
  friend Fused operator/(const Fused& a, const Fused& b) { return Fused(a.x / b.x); }
  friend bool operator!=(const Fused& a, const Fused& b) { return a.x != b.x; }
};

template <>
struct ScalarTraits<Fused> {
  using Mask = bool;
  static constexpr int lanes = 1;
};

inline void sincos(const Fused& a, Fused& s, Fused& c) { sincos(a.x, s.x, c.x); }

}  // namespace lacuna
