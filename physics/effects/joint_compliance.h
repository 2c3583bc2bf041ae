#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A spring between actuator and link; the actuator's side has damping but no mass. With f the spring's effort, tau0 what
/// the actuator would give rigidly, D and S its damping and stiffness: f' = (k/D) (tau0 - (1 + S/k) f), solved for a tau0
/// that changes linearly over a step. Neutral at k = infinity.
struct JointCompliance {
  static EffectInfo info() {
    return {"joint_compliance",
            "Joint compliance",
            Where::joint,
            "spring k in series with the actuator",
            "ringing, phase",
            "stiffness, actuator_lag",
            "M. W. Spong, J. Dyn. Sys. Meas. Control 109 (1987), at zero motor inertia",
            {{"k",
              "N m/rad",
              HUGE_VAL,
              1e-6,
              HUGE_VAL,
              "stiffness of the spring",
              Scale::stiffness,
              {100.0, 10.0},
              Coordinate::inverse}}};
  }
  static constexpr int memories = 2;  // f, and tau0 at the same instant; N m
  template <class T>
  static void begin(const T*, const JointView<T>&, T* now) {
    now[0] = now[1] = T(HUGE_VAL);  // not known yet: the first look takes the rigid effort
  }
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T& dt, const T* before, T* now) {
    const T give = T(1.0) / p[0];
    const T share = T(1.0) / (T(1.0) + s.stiffness * give);  // f in the long run over tau0
    const T time = give * s.damping * share;                 // s
    const Mask<T> known = before[0] < T(HUGE_VAL);
    const T f0 = select(known, before[0], s.drive * share), tau0 = select(known, before[1], s.drive);
    const T slope = select(dt > T(0.0), (s.drive - tau0) / max(dt, T(1e-300)), T(0.0)) * share;
    const T left = select(time > T(0.0), exp(T(0.0) - min(dt / max(time, T(1e-300)), T(700.0))), T(0.0));
    const T start = select(dt > T(0.0), tau0, s.drive) * share - slope * time;
    const T f = s.drive * share - slope * time + (f0 - start) * left;
    now[0] = select(dt > T(0.0), f, select(time > T(0.0), f0, s.drive * share));
    now[1] = s.drive;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return select(T(1.0) / p[0] > T(0.0), s.m[0] - s.drive, T(0.0));
  }
};

}  // namespace lacuna
