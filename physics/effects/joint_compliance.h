#pragma once

#include "physics/effects/transmission.h"

namespace lacuna {

/// A spring between actuator and link. The actuator's side carries the actuator's own damper and spring: a load bends
/// the joint by load/k, and a command arrives late by about D/k. Neutral at k = infinity.
struct JointCompliance : SideOfItsOwn<JointCompliance> {
  static EffectInfo info() {
    EffectInfo info{"joint_compliance",
                    "Joint compliance",
                    Where::joint,
                    Stage::transmission,
                    "tau = k (theta - q) + c (theta' - v); J theta'' = K u - D theta' - S (theta - rest) - tau",
                    "the joint gives under load; ringing, phase",
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
                     side_inertia(),
                     spring_damping()}};
    info.contains = "armature";
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return select(acts(p), side(p, s).carried(s.drive, s.z[0] - s.q, s.z[1] - s.v) - s.drive, T(0.0));
  }

  template <class T>
  static T lead(const T* p, const T& effort) {
    return effort / p[0];
  }

  template <class T>
  static Mask<T> acts(const T* p) {
    return T(1.0) / p[0] > T(0.0);
  }
  template <class T>
  static Transmission<T> side(const T* p, const JointView<T>& s) {
    return Transmission<T>::of(s, p[0], p[2], T(0.0), p[1]);
  }
};

}  // namespace lacuna
