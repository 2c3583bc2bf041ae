#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// First-order lag between command and effect. Exact for a command held over a step, however short T is. Neutral at T = 0.
struct ActuatorLag {
  static EffectInfo info() {
    return {"actuator_lag",
            "Actuator lag",
            Where::joint,
            "T w' = u - w; w takes the place of u",
            "a lag whose phase bends with frequency, and smaller fast commands",
            "input_delay, damping",
            "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 7 (valve dynamics)",
            {{"T", "s", 0.0, 0.0, 5.0, "time constant", Scale::time, {0.01, 0.05}}}};
  }
  static constexpr int memories = 1;
  template <class T>
  static void begin(const T*, const JointView<T>& s, const T&, T* now) {
    now[0] = s.u;
  }
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T& dt, const T* before, T* now) {
    const T left = exp(T(0.0) - min(dt / max(p[0], T(1e-12)), T(700.0)));
    now[0] = select(p[0] > T(0.0), s.u + (before[0] - s.u) * left, s.u);
  }
  template <class T>
  static T command(const T*, const JointView<T>& s) {
    return s.m[0];
  }
};

}  // namespace lacuna
