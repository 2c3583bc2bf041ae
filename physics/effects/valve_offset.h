#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The valve's null lies beside the electrical zero.
struct ValveOffset {
  static EffectInfo info() {
    return {"valve_offset",
            "Valve offset",
            Where::joint,
            Stage::valve,
            "u -> u + b",
            "a constant push",
            "rest, gravity, sensor_offset",
            "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 7 (null bias)",
            {{"b", "V", 0.0, -1e6, 1e6, "command added", Scale::command, {0.03}}}};
  }
  static constexpr bool curve = true;
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u + p[0];
  }
};

}  // namespace lacuna
