#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Large commands fall short: a smooth cap. Neutral at cap = infinity.
struct ActuatorSaturation {
  static EffectInfo info() {
    return {"actuator_saturation",
            "Actuator saturation",
            Where::joint,
            "u -> cap tanh(u / cap)",
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
              Coordinate::inverse}}};
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    const T inverse = T(1.0) / p[0];
    const T safe = max(inverse, T(1e-12));
    return select(inverse > T(1e-12), tanh(s.u * safe) / safe, s.u);
  }
};

}  // namespace lacuna
