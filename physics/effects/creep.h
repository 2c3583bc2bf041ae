// Shared by the dry frictions: how the sign of the speed is softened.
#pragma once

#include <string_view>

#include "physics/catalogue.h"

namespace lacuna {

/// The parameter v0 of a friction: 0 is the exact sign.
inline ParameterInfo creep_speed() {
  ParameterInfo info{"v0",  "rad/s", 0.0, 0.0, 1e3, "speed over which the sign builds up; 0: at once", Scale::velocity,
                     {0.03}};
  info.optional = true;
  return info;
}

/// Whether a number is that one. A creeping contact holds nothing at rest. That is a way of simulating sliding, not
/// what a machine's joint does that stands under load: where efforts are explained from the motion, friction at rest is
/// what it was when the joint last slid, and what builds up after a turn goes with the way (bristles), not with the
/// speed.
inline bool is_creep_speed(const ParameterInfo& p) {
  const ParameterInfo creep = creep_speed();
  return p.optional && p.neutral == creep.neutral && std::string_view(p.name) == creep.name;
}

/// -size tanh(v / v0) where v0 > 0, else nothing (the exact sign is the rollout's business).
template <class T>
T creeping(const T& size, const T& v0, const T& v) {
  if (!any(v0 > T(0.0))) return T(0.0);  // the commonest case, and tanh is dear
  const T soft = T(0.0) - size * tanh(v / max(v0, T(1e-9)));
  return select(v0 > T(0.0), soft, T(0.0));
}

}  // namespace lacuna
