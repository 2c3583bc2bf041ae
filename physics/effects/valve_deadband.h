#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The spool's overlap: commands within +-d do nothing.
struct ValveDeadband {
  static EffectInfo info() {
    return {"valve_deadband",
            "Valve deadband",
            Where::joint,
            Stage::valve,
            "u -> sgn(u) max(|u| - d, 0)",
            "small commands do nothing",
            "gain, coulomb_friction",
            "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 5",
            {{"d", "V", 0.0, 0.0, 1e6, "half-width of the dead zone", Scale::command, {0.05, 0.2}}}};
  }
  static constexpr bool curve = true;
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return sign(s.u) * max(abs(s.u) - p[0], T(0.0));
  }
};

}  // namespace lacuna
