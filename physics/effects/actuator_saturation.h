#pragma once

#include "physics/effects/cap.h"

namespace lacuna {

/// Large commands fall short: a cap, smooth as in cap.h. Neutral at cap = infinity.
struct ActuatorSaturation {
  static EffectInfo info() {
    return {"actuator_saturation",
            "Actuator saturation",
            Where::joint,
            Stage::valve,
            "u -> u (1 + |u/cap|^n)^(-1/n)",
            "only large commands fall short",
            "gain",
            "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 5 (flow saturation)",
            {{"cap",
              "V",
              HUGE_VAL,
              1e-3,
              HUGE_VAL,
              "largest command that takes effect",
              Scale::command,
              {3.0, 1.2},
              Coordinate::inverse},
             cap_sharpness()}};
  }
  static constexpr bool curve = true;
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u * capped_share(abs(s.u) / p[0], p[1]);
  }
};

}  // namespace lacuna
