#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The two directions of a cylinder with unequal areas, or of a valve with unequal edges: a gain, so it acts behind a
/// saturation, and the two directions' largest speeds differ by it, too. Neutral at a = 0.
struct ValveAsymmetry {
  static EffectInfo info() {
    EffectInfo info{"valve_asymmetry",
                    "Valve asymmetry",
                    Where::joint,
                    Stage::valve,
                    "u -> (1 - a) u for u < 0",
                    "one direction weaker",
                    "valve_offset, damping_asymmetry",
                    "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 5",
                    {{"a", "1", 0.0, -5.0, 1.0, "share by which negative commands are weaker", Scale::ratio, {0.1}}}};
    info.hydraulic = true;
    return info;
  }
  static constexpr bool curve = true;
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return select(s.u < T(0.0), (T(1.0) - p[0]) * s.u, s.u);
  }
};

}  // namespace lacuna
