#pragma once

#include "physics/effects/cap.h"

namespace lacuna {

/// One pump for all joints: whatever flows anywhere lowers the pressure everywhere. Neutral at depth = 0.
struct SupplyPressureSag {
  static EffectInfo info() {
    ParameterInfo flow{"flow",
                       "rad/s",
                       HUGE_VAL,
                       1e-4,
                       HUGE_VAL,
                       "speed of that joint alone which takes all the pump gives",
                       Scale::velocity,
                       {3.0, 12.0},
                       Coordinate::inverse};
    flow.per_joint = true;
    ParameterInfo depth{"depth", "1", 0.0, -1.0, 1.0, "share of the gain lost at large flow", Scale::ratio, {0.2}};
    EffectInfo info{"supply_pressure_sag",
                    "Supply pressure sag",
                    Where::arm,
                    Stage::flow,
                    "u_j -> u_j (1 - depth x (1 + x^n)^(-1/n)), x = sum over joints of |v_i|/flow_i",
                    "a joint is weak exactly when others move",
                    "actuator_saturation, gain",
                    "pump curve and relief valve in series; H. E. Merritt, Hydraulic Control Systems, 1967, ch. 11",
                    {depth, cap_sharpness(), flow}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    T x(0.0);
    for (int i = 0; i < s.joints; ++i) x = x + abs(s.speeds[i]) / p[2 + i];
    return s.u * (T(1.0) - p[0] * x * capped_share(x, p[1]));
  }
};

}  // namespace lacuna
