#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// One pump for all joints: whatever flows anywhere lowers the pressure everywhere. Neutral at depth = 0.
struct SupplyPressureSag {
  static EffectInfo info() {
    return {"supply_pressure_sag",
            "Supply pressure sag",
            Where::arm,
            "u_j -> u_j (1 - depth (1 - exp(-D/flow))), D = sum of |u| over the joints",
            "a joint is weak exactly when others move",
            "actuator_saturation, gain",
            "pump curve and relief valve in series; H. E. Merritt, Hydraulic Control Systems, 1967, ch. 11",
            {{"depth", "1", 0.0, -1.0, 1.0, "share of the gain lost at large demand", Scale::ratio, {0.2}},
             {"flow", "V", 10.0, 1e-3, 1e6, "demand at which most of it is lost", Scale::command, {2.0, 10.0}}}};
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u * (T(1.0) - p[0] * (T(1.0) - exp(T(0.0) - min(s.demand / p[1], T(700.0)))));
  }
};

}  // namespace lacuna
