#pragma once

#include "physics/effects/learned_curve.h"

namespace lacuna {

/// What a transducer adds to the joint's own position, and nobody wrote down.
struct LearnedReading {
  static EffectInfo info() {
    return LearnedCurve::info("learned_reading", "Learned reading", Stage::reading,
                              "reading = q + f(q), f by its values at knots", "rad", Scale::position);
  }
  template <class T>
  static void sense(const T* p, const std::vector<T>& time, T* q, std::size_t stride) {
    for (std::size_t k = 0; k < time.size(); ++k) q[k * stride] = q[k * stride] + error(p, q[k * stride]);
  }
  /// By fixed point, which arrives where the error grows slower than the position does.
  template <class T>
  static T unsense(const T* p, const T& reading) {
    constexpr int kRounds = 50;
    T q = reading;
    for (int k = 0; k < kRounds; ++k) q = reading - error(p, q);
    return q;
  }

 private:
  template <class T>
  static T error(const T* p, const T& q) {
    JointView<T> s;
    s.q = q;
    return LearnedCurve::at(p, s);
  }
};

}  // namespace lacuna
