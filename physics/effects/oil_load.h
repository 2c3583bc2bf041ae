// Shared by what the load does to a drive that integrates its flow.
#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// s, that a direct-acting relief valve takes to open.
inline constexpr double kReliefOpens = 1e-3;

/// N m (N), that the oil spring carries when it has been brought to `oil`: what the load makes of the pressures.
template <class T>
T oil_load(const JointView<T>& s, const T& oil) {
  return s.stiffness * (oil - s.q);
}

}  // namespace lacuna
