#pragma once

#include "physics/effects/oil_load.h"

namespace lacuna {

/// Contact at an end of the travel. k > 0: an upper stop, active beyond q_lim; k < 0: a lower one, active below it.
/// Neutral at k = 0. A cylinder has two: the opposite one, of the same make, lies `travel` away. A valve's flow that
/// would drive on against a stop leaves through the relief valve, so the oil spring takes up no more of it.
struct EndStop {
  static EffectInfo info() {
    return {"end_stop",
            "End stop",
            Where::joint,
            Stage::link,
            "k > 0, beyond q_lim: tau -= max(k (q - q_lim + T v), 0); k < 0: the same on the other side; the opposite "
            "stop a travel away",
            "motion clipped at one angle, or at two",
            "stiffness_hardening",
            "linear penalty contact (Kelvin and Voigt), no adhesion",
            {{"q_lim", "rad", 0.0, -1e3, 1e3, "where the contact begins", Scale::reach, {0.7, -0.7, 0.99, -0.99}},
             stiffness(),
             {"T",
              "s",
              0.0,
              0.0,
              0.05,
              "damping of the contact over its stiffness",
              Scale::time,
              {0.002},
              Coordinate::linear,
              true},
             travel()}};
  }
  static ParameterInfo stiffness() {
    ParameterInfo k{"k",
                    "N m/rad",
                    0.0,
                    -1e9,
                    1e9,
                    "contact stiffness; negative: a lower stop",
                    Scale::stiffness,
                    {1.0, -1.0, 100.0, -100.0}};
    k.least = 10.0;  // the drive's usual effort presses it in by a tenth of the usual motion at most
    return k;
  }
  static ParameterInfo travel() {
    ParameterInfo far{"travel",      "rad",  kNone,
                      1e-6,          kNone,  "from this stop to the opposite one; 1e6: none",
                      Scale::travel, {0.99}, Coordinate::inverse};
    far.optional = true;
    return far;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T side = side_of(p);
    return push(p, side * (s.q - p[0]), side * s.v) * (T(0.0) - side) +
           push(p, T(0.0) - side * (s.q - p[0]) - p[3], T(0.0) - side * s.v) * side;
  }
  /// The flow ends over as much of the oil's position as it passes in the time that a relief valve takes to open, or in
  /// the shortest that the steps can follow.
  template <class T>
  static T taken(const T* p, const JointView<T>& s, const T& oil, const T& flow) {
    const T side = side_of(p), inward = side * (oil - p[0]), way = side * flow;
    const T depth = max(abs(flow) * max(s.resolved, T(kReliefOpens)), T(1e-12));
    const T left = T(1.0) - select(way > T(0.0), inward, T(0.0) - inward - p[3]) / depth;
    return select(p[1] == T(0.0), flow, flow * min(max(left, T(0.0)), T(1.0)));
  }

 private:
  static constexpr double kNone = 1e6;  ///< rad, further than anything travels
  template <class T>
  static T side_of(const T* p) {
    return select(p[1] > T(0.0), T(1.0), T(-1.0));
  }
  /// Of one contact, `beyond` its beginning and going in at `speed`.
  template <class T>
  static T push(const T* p, const T& beyond, const T& speed) {
    return select(beyond > T(0.0), abs(p[1]) * max(beyond + p[2] * speed, T(0.0)), T(0.0));
  }
};

}  // namespace lacuna
