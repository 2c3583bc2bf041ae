#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// An effort transducer, or a drive's torque constant, of another sensitivity: constants are known to some 10 %, and
/// all masses found from such efforts inherit that. The motion is not touched. Neutral at s = 0.
struct EffortScale {
  static EffectInfo info() {
    return {"effort_scale",
            "Effort scale",
            Where::joint,
            Stage::reading,
            "measured effort = (1 + s) effort",
            "all efforts measured in proportion too large or too small",
            "gain, masses",
            "M. Gautier, S. Briot, Global identification of joint drive gains, J. Dyn. Sys. Meas. Control 136 (2014)",
            {{"s", "1", 0.0, -0.9, 10.0, "error of the sensitivity", Scale::ratio, {0.05}}}};
  }
  template <class T>
  static T measure(const T* p, const T& effort) {
    return (T(1.0) + p[0]) * effort;
  }
};

}  // namespace lacuna
