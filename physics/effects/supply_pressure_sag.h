#pragma once

#include "physics/effects/cap.h"

namespace lacuna {

/// One pump for all joints: whatever flows anywhere lowers the pressure everywhere. Neutral at depth = 0.
struct SupplyPressureSag {
  static EffectInfo info() {
    EffectInfo info{
        "supply_pressure_sag",
        "Supply pressure sag",
        Where::arm,
        "u_j -> u_j (1 - depth x (1 + x^n)^(-1/n)), x = Q/flow, Q the sum of |v| over the joints",
        "a joint is weak exactly when others move",
        "actuator_saturation, gain",
        "pump curve and relief valve in series; H. E. Merritt, Hydraulic Control Systems, 1967, ch. 11",
        {{"depth", "1", 0.0, -1.0, 1.0, "share of the gain lost at large flow", Scale::ratio, {0.2}},
         {"flow", "rad/s", 10.0, 1e-4, 1e6, "total speed at which most of it is lost", Scale::velocity, {1.0, 5.0}},
         cap_sharpness()}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    const T x = s.flow / p[1];
    return s.u * (T(1.0) - p[0] * x * capped_share(x, p[2]));
  }
};

}  // namespace lacuna
