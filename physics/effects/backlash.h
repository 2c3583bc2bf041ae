#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A gap between actuator and link: the actuator's side, without mass, is carried along once the gap is closed, so its
/// spring sees the link's motion through a play. Neutral at gap = 0.
struct Backlash {
  static EffectInfo info() {
    return {"backlash",
            "Backlash",
            Where::joint,
            "tau += stiffness (q - x), x the play of width gap on q",
            "lost motion after each reversal",
            "sensor_backlash, valve_hysteresis",
            "M. Nordin and P.-O. Gutman, Automatica 38 (2002)",
            {{"gap", "rad", 0.0, 0.0, 10.0, "whole width of the gap", Scale::position, {0.02, 0.1}}}};
  }
  static constexpr int memories = 1;
  template <class T>
  static void begin(const T*, const JointView<T>& s, T* now) {
    now[0] = s.q;
  }
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T&, const T* before, T* now) {
    const T half = T(0.5) * p[0];
    now[0] = max(min(before[0], s.q + half), s.q - half);
  }
  template <class T>
  static T effort(const T*, const JointView<T>& s) {
    return s.stiffness * (s.q - s.m[0]);
  }
};

}  // namespace lacuna
