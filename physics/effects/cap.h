// Shared by what levels off: a smooth cap whose corner may be sharp or round.
#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// How sharply it bends: 1 is a hyperbola, large values approach a corner.
inline ParameterInfo cap_sharpness() {
  ParameterInfo info{"n", "1", 3.0, 0.5, 100.0, "sharpness of the bend", Scale::ratio, {8.0}};
  info.optional = true;
  return info;
}

/// (1 + x^n)^(-1/n) for x >= 0: 1 at 0, 1/x far out.
template <class T>
T capped_share(const T& x, const T& n) {
  const T safe = min(max(x, T(1e-30)), T(1e30));
  const T power = exp(min(n * log(safe), T(600.0)));
  return select(x > T(0.0), exp(T(0.0) - log(T(1.0) + power) / n), T(1.0));
}

}  // namespace lacuna
