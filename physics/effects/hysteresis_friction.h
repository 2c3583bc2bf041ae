#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Friction through bristles that bend before they slide (Dahl): a spring of sigma0 up to Fc. Depends on the path
/// alone, so the bristles are carried exactly from position to position. Neutral at Fc = 0.
struct HysteresisFriction {
  static EffectInfo info() {
    EffectInfo info{
        "hysteresis_friction",
        "Hysteresis friction",
        Where::joint,
        Stage::link,
        "tau -= sigma0 z + sigma1 dz/dt; dz = (1 - sigma0 z sgn(dq)/Fc) dq",
        "loops before break-away",
        "coulomb_friction, stiffness",
        "P. R. Dahl, AIAA Journal 14 (1976); LuGre at constant friction: Canudas de Wit et al., IEEE TAC 40 (1995)",
        {{"Fc", "N m", 0.0, 0.0, 1e9, "friction effort in motion", Scale::effort, {0.05}},
         {"sigma0", "N m/rad", 1e3, 1e-6, 1e12, "stiffness of the bristles", Scale::stiffness, {1.0, 8.0}},
         {"sigma1",
          "N m s/rad",
          0.0,
          0.0,
          1e9,
          "damping of the bristles",
          Scale::damping,
          {0.02},
          Coordinate::linear,
          true}}};
    // Bristles that bend over more than the whole travel never slide, and are a push that each start sets anew: a
    // friction of a twentieth of the usual effort must slide within the usual motion.
    info.parameters[1].least = 0.05;
    info.in_parallel = true;
    return info;
  }
  static constexpr int memories = 2;  // the bristles' effort, N m; the position it belongs to, rad
  template <class T>
  static void begin(const T* p, const JointView<T>& s, const T& excess, T* now) {
    now[0] = max(min(excess, p[0]), T(0.0) - p[0]);  // at rest they hold what they can
    now[1] = s.q;
  }
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T&, const T* before, T* now) {
    const T way = s.q - before[1], limit = p[0] * sign(way);
    const T left = exp(T(0.0) - min(abs(way) * p[1] / max(p[0], T(1e-12)), T(700.0)));
    now[0] = select(p[0] > T(0.0), limit + (before[0] - limit) * left, T(0.0));
    now[1] = s.q;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T bending = s.v - abs(s.v) * s.m[0] / max(p[0], T(1e-12));
    return T(0.0) - s.m[0] - select(p[0] > T(0.0), p[2] * bending, T(0.0));
  }
};

}  // namespace lacuna
