#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// First-order lag between command and effect. Exact for a command held over a step. Within a step the decay
/// exp(-t/T) is given as the parabola nearest to it (Legendre coefficients): Kutta's step integrates that exactly, so
/// that a lag far shorter than the step acts by the delay T that it is, smoothly down to T = 0, where it is neutral.
struct ActuatorLag {
  static EffectInfo info() {
    return {"actuator_lag",
            "Actuator lag",
            Where::joint,
            Stage::valve,
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
    const T time = max(p[0], T(1e-12));
    const T left = select(s.step > T(0.0), parabola(s.step / time, dt / max(s.step, T(1e-300))), decay(dt / time));
    now[0] = select(p[0] > T(0.0), s.u + (before[0] - s.u) * left, s.u);
  }
  template <class T>
  static T command(const T*, const JointView<T>& s) {
    return s.m[0];
  }

 private:
  template <class T>
  static T decay(const T& x) {
    return exp(T(0.0) - min(x, T(700.0)));
  }
  /// At s in [0, 1], the parabola that has the moments of exp(-x s) up to the second there.
  template <class T>
  static T parabola(const T& x, const T& s) {
    T m0, m1, m2;
    moments(x, m0, m1, m2);
    const T a1 = T(3.0) * (T(2.0) * m1 - m0), a2 = T(5.0) * (T(6.0) * (m2 - m1) + m0);
    return m0 + a1 * (T(2.0) * s - T(1.0)) + a2 * (T(6.0) * s * (s - T(1.0)) + T(1.0));
  }
  /// Integrals of s^k exp(-x s) over [0, 1]: by series where the closed form would cancel.
  template <class T>
  static void moments(const T& x, T& m0, T& m1, T& m2) {
    const Mask<T> small = x < T(0.25);
    const T y = select(small, x, T(0.0)), z = select(small, T(1.0), x), e = decay(z);
    T s0(0.0), s1(0.0), s2(0.0), term(1.0);
    for (int k = 0; k < 10; ++k) {
      s0 = s0 + term * T(1.0 / (k + 1)), s1 = s1 + term * T(1.0 / (k + 2)), s2 = s2 + term * T(1.0 / (k + 3));
      term = T(0.0) - term * y * T(1.0 / (k + 1));
    }
    m0 = select(small, s0, (T(1.0) - e) / z);
    m1 = select(small, s1, (T(1.0) - e * (T(1.0) + z)) / (z * z));
    m2 = select(small, s2, (T(2.0) - e * (T(2.0) + z * (T(2.0) + z))) / (z * z * z));
  }
};

}  // namespace lacuna
