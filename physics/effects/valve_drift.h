#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The valve's null moves while oil and coils warm, over the session, one recording after the other; in the model's
/// numbers it has not moved yet. Neutral at b = 0.
struct ValveDrift {
  static EffectInfo info() {
    EffectInfo info{"valve_drift",
                    "Drift of the valve's null",
                    Where::joint,
                    Stage::valve,
                    "u -> u + b (1 - exp(-t/tau)), t from the start of the session",
                    "a push that differs from recording to recording",
                    "valve_offset, thermal_drift",
                    "null shift with temperature: H. E. Merritt, Hydraulic Control Systems, 1967, ch. 7; first-order "
                    "warming",
                    {{"b", "V", 0.0, -1e6, 1e6, "command added in the end", Scale::command, {0.03, -0.03}},
                     {"tau", "s", 10.0, 1e-2, 1e6, "time constant of the warming", Scale::span, {0.4, 4.0}}}};
    info.metering = true;
    info.in_parallel = true;  // beside an offset that was there from the start
    return info;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u + p[0] * (T(1.0) - exp(T(0.0) - min(s.t / p[1], T(700.0))));
  }
};

}  // namespace lacuna
