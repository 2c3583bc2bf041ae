// Shared by the dry frictions: how the sign of the speed is softened.
#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The parameter v0 of a friction: 0 is the exact sign.
inline ParameterInfo creep_speed() {
  ParameterInfo info{"v0",  "rad/s", 0.0, 0.0, 1e3, "speed over which the sign builds up; 0: at once", Scale::velocity,
                     {0.03}};
  info.optional = true;
  return info;
}

/// -size tanh(v / v0) where v0 > 0, else nothing (the exact sign is the rollout's business).
template <class T>
T creeping(const T& size, const T& v0, const T& v) {
  if (!any(v0 > T(0.0))) return T(0.0);  // the commonest case, and tanh is dear
  const T soft = T(0.0) - size * tanh(v / max(v0, T(1e-9)));
  return select(v0 > T(0.0), soft, T(0.0));
}

}  // namespace lacuna
