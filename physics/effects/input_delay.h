#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Pure transport delay of the command. The rollout splits its steps where the delayed command jumps.
struct InputDelay {
  static EffectInfo info() {
    return {"input_delay",
            "Input delay",
            Where::joint,
            Stage::command,
            "u(t) -> u(t - T)",
            "a lag whose phase grows linearly with frequency",
            "actuator_lag, damping",
            "any text on sampled control, e.g. Astrom and Wittenmark, Computer-Controlled Systems, 1997",
            {{"T", "s", 0.0, 0.0, 1.0, "delay", Scale::time, {0.005, 0.03}}}};
  }
  template <class T>
  static T delay(const T* p) {
    return p[0];
  }
};

}  // namespace lacuna
