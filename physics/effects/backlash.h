#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A gap between actuator and link. In contact the link gets what the actuator gives; within the gap it gets nothing, and
/// the actuator's side, without mass, crosses the gap against its own damper and spring: with e its lead over the link,
/// e' = (tau0 - S e)/D between -gap/2 and gap/2, tau0 the effort it would give at e = 0. Neutral at gap = 0.
struct Backlash {
  static EffectInfo info() {
    return {"backlash",
            "Backlash",
            Where::joint,
            "no effort while the actuator crosses a gap of this width",
            "lost motion after each reversal",
            "sensor_backlash, valve_hysteresis",
            "M. Nordin and P.-O. Gutman, Automatica 38 (2002): dead zone between sides, driving side without mass",
            {{"gap", "rad", 0.0, 0.0, 10.0, "whole width of the gap", Scale::position, {0.02, 0.1}}}};
  }
  static constexpr int memories = 1;  // e, rad
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T& dt, const T* before, T* now) {
    const T half = T(0.5) * p[0];
    now[0] = max(min(lead(s, dt, before[0]), half), T(0.0) - half);
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T half = T(0.5) * p[0], e = s.m[0], push = s.drive - s.stiffness * e;
    const Mask<T> contact = (abs(e) >= half) && (push * e >= T(0.0));
    return select(p[0] > T(0.0), select(contact, T(0.0) - s.stiffness * e, T(0.0) - s.drive), T(0.0));
  }

 private:
  template <class T>
  static T lead(const JointView<T>& s, const T& dt, const T& e) {
    const T x = s.stiffness * dt / max(s.damping, T(1e-12));
    const T share = select(x > T(1e-9), (T(1.0) - exp(T(0.0) - min(x, T(700.0)))) / max(x, T(1e-9)), T(1.0));
    return e + (s.drive - s.stiffness * e) / max(s.damping, T(1e-12)) * dt * share;
  }
};

}  // namespace lacuna
