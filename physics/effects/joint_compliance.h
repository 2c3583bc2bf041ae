#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A spring between actuator and link. What the command gives drives the actuator's side, which has an inertia J of its own
/// (J theta'' = that - f) and pulls the link by f = k (theta - q) + c (theta' - v), c = 2 zeta sqrt(k J); the actuator's
/// damper and spring act on the link, as in the plain model. Neutral at k = infinity.
struct JointCompliance {
  static EffectInfo info() {
    return {"joint_compliance",
            "Joint compliance",
            Where::joint,
            "the command's effort reaches the link through a spring k, from a side of inertia J",
            "ringing, phase",
            "stiffness, actuator_lag, input_delay",
            "M. W. Spong, J. Dyn. Sys. Meas. Control 109 (1987)",
            {{"k",
              "N m/rad",
              HUGE_VAL,
              1e-6,
              HUGE_VAL,
              "stiffness of the spring",
              Scale::stiffness,
              {100.0, 10.0},
              Coordinate::inverse},
             {"J", "kg m^2", 0.1, 1e-9, 1e9, "inertia of the actuator's side", Scale::inertia, {0.02, 0.2}},
             {"zeta", "1", 0.2, 0.0, 10.0, "damping ratio of that side on its spring", Scale::ratio, {0.2}}}};
  }
  static constexpr int states = 2;  // theta, rad, and theta', rad/s
  template <class T>
  static void initial(const T* p, const JointView<T>& s, const T& holding, T* out) {
    out[0] = s.q + (holding + s.stiffness * (s.q - s.rest)) / p[0];
    out[1] = s.v;
  }
  template <class T>
  static void rate(const T* p, const JointView<T>& s, T* out) {
    const Mask<T> rigid = !(T(1.0) / p[0] > T(0.0));
    out[0] = select(rigid, s.v, s.z[1]);
    out[1] = select(rigid, T(0.0), (driven(s) - pull(p, s)) / p[1]);
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return select(T(1.0) / p[0] > T(0.0), pull(p, s) - driven(s), T(0.0));
  }

 private:
  template <class T>
  static T driven(const JointView<T>& s) {
    return s.drive + s.damping * s.v + s.stiffness * (s.q - s.rest);
  }
  template <class T>
  static T pull(const T* p, const JointView<T>& s) {
    return p[0] * (s.z[0] - s.q) + T(2.0) * p[2] * sqrt(p[0] * p[1]) * (s.z[1] - s.v);
  }
};

}  // namespace lacuna
