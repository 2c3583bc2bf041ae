// Shared by what lies between actuator and link: a side of the actuator's own, of inertia J, that carries the
// actuator's damper and spring and pulls the link through a spring k with its damper c, after free travel to both
// sides.
#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// With e the lead of that side over the link and tau0 the effort that the actuator would give at e = 0, e' = 0:
/// J theta'' = tau0 - D e' - S e - f; f = k (e - half) + c e' beyond half, k (e + half) + c e' below -half, zero
/// between and where a surface would have to pull. Nothing faster than the steps can follow is resolved (s.resolved): J
/// counts at least D times that, D + c at most J over it, k at most J over its square (all smoothly, so that a search
/// that strays there finds back). J does not grow with c: a fit would take a large c for the inertia that it lacks, and
/// another one at every step. No stiffness upsets the rollout, and finer steps resolve more.
template <class T>
struct Transmission {
  T k, c, half, S, D, J;  ///< N m/rad, N m s/rad, rad, N m/rad, N m s/rad, kg m^2 (N/m, N s/m, m, N/m, N s/m, kg)
  T share, bend;          ///< of J that is the side's own, of the lead that k itself lets happen

  static Transmission of(const JointView<T>& s, const T& k, const T& c, const T& half, const T& inertia) {
    constexpr double kLeast = 1e-9;  // kg m^2: a side without a damper keeps some
    const T J = max(rounded_max(inertia, s.damping * s.resolved), T(kLeast));
    const T softness = rounded_max(T(1.0) / k, s.resolved * s.resolved / J);
    const T room = max(J / max(s.resolved, T(1e-300)) - s.damping, T(kLeast)), loss = c / rounded_max(T(1.0), c / room);
    return {T(1.0) / softness, loss, half, s.stiffness, s.damping, J, inertia / J, T(1.0) / (k * softness)};
  }

  /// Effort on the link. Surfaces with a gap between them push only.
  T effort(const T& e, const T& rate) const {
    const T loss = c * rate;
    const T up = select(e > half, max(k * (e - half) + loss, T(0.0)), T(0.0));
    const T pushed = select(e < T(0.0) - half, min(k * (e + half) + loss, T(0.0)), up);
    return select(half > T(0.0), pushed, k * e + loss);
  }

  /// The same where there is no free travel: what J was raised by and k lowered to leave no trace, so that a stiff
  /// spring is an armature, and before a light side the plain model. The side's own damper and spring feel the whole
  /// lead, which keeps its motion damped; what of that k itself would not let happen is given back.
  T carried(const T& tau0, const T& e, const T& rate) const {
    const T own = D * rate + S * e, give = bend * own;
    return share * (effort(e, rate) + own - give) + (T(1.0) - share) * (tau0 - give);
  }

  /// Lead at which the side rests under tau0 while the link is held.
  T settled(const T& tau0) const {
    const Mask<T> flies = abs(tau0) <= S * half;
    const T free = select(abs(tau0) > T(0.0), tau0 / max(S, T(1e-12)), T(0.0));
    const T surface = sign(tau0) * half, give = select(half > T(0.0), bend, T(1.0));
    return select(flies, free, surface + (tau0 - S * surface) / (k + S * give));
  }

  /// theta'' at lead e and its rate. What lowering k lets a surface give way by, the side's own spring and damper do
  /// not feel: a stiff contact carries its load as if k were what it is.
  T acceleration(const T& tau0, const T& e, const T& rate) const {
    const T surface = max(min(e, half), T(0.0) - half);
    const T give = select((half > T(0.0)) && (abs(e) > half), bend, T(1.0));
    return (tau0 - give * D * rate - S * (surface + give * (e - surface)) - effort(e, rate)) / J;
  }
};

/// The hooks that carry the actuator's side of effect E, which says when it acts and by which Transmission.
template <class E>
struct SideOfItsOwn {
  static constexpr int states = 2;  // theta, rad, and theta', rad/s
  template <class T>
  static void initial(const T* p, const JointView<T>& s, const T&, T* out) {
    out[0] = s.q + select(E::acts(p), E::side(p, s).settled(s.drive), T(0.0));
    out[1] = s.v;
  }
  template <class T>
  static void rate(const T* p, const JointView<T>& s, T* out) {
    const Mask<T> acts = E::acts(p);
    out[0] = select(acts, s.z[1], s.v);
    out[1] = select(acts, E::side(p, s).acceleration(s.drive, s.z[0] - s.q, s.z[1] - s.v), T(0.0));
  }
};

inline ParameterInfo side_inertia() {
  return {"J",
          "kg m^2",
          0.0,
          0.0,
          1e9,
          "inertia of the actuator's side",
          Scale::inertia,
          {0.05, 0.3},
          Coordinate::logarithm};
}

inline ParameterInfo spring_damping() {
  return {"c", "N m s/rad", 0.0, 0.0, 1e9, "damping of the spring", Scale::damping, {0.5}, Coordinate::linear, true};
}

}  // namespace lacuna
