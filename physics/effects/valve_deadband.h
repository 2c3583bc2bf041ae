#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The spool's overlap: commands within +-d do nothing. Beyond its edge the opening may grow progressively, as of a
/// spool with metering notches, whose width grows with the stroke.
struct ValveDeadband {
  static EffectInfo info() {
    return {"valve_deadband",
            "Valve deadband",
            Where::joint,
            Stage::valve,
            "u -> sgn(u) (x + b x^2), x = max(|u| - d, 0)",
            "small commands do nothing",
            "gain, coulomb_friction",
            "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 5",
            {{"d", "V", 0.0, 0.0, 1e6, "half-width of the dead zone", Scale::command, {0.05, 0.2}}, bend()}};
  }
  static ParameterInfo bend() {
    ParameterInfo b{"b", "1/V", 0.0, 0.0, 1e6, "progression of the opening beyond the edge", Scale::per_command, {1.0}};
    b.optional = true;
    return b;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    const T x = max(abs(s.u) - p[0], T(0.0));
    return sign(s.u) * x * (T(1.0) + p[1] * x);
  }
};

}  // namespace lacuna
