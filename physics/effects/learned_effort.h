#pragma once

#include <algorithm>

#include "physics/catalogue.h"

namespace lacuna {

/// A law that nobody wrote down, as its values at evenly spaced places of the joint's position or speed, with cubic
/// convolution between them (R. G. Keys, IEEE Trans. ASSP 29, 1981); beyond the outermost it stays as it is there.
/// Neutral where all values are zero or there are none.
struct LearnedEffort {
  static EffectInfo info() {
    ParameterInfo value{"value", "N m", 0.0, -1e9, 1e9, "effort at a knot", Scale::effort, {0.05}};
    value.per_knot = true;
    EffectInfo info{"learned_effort",
                    "Learned effort",
                    Where::joint,
                    Stage::link,
                    "tau += f(q) or f(v), f through its values at evenly spaced knots",
                    "whatever it was learned from",
                    "nothing that has a name",
                    "cubic convolution: R. G. Keys, IEEE Trans. ASSP 29 (1981)",
                    {{"over", "1", 0.0, 0.0, 1.0, "0: the joint's position, 1: its speed"},
                     {"from", "rad, rad/s", 0.0, -1e9, 1e9, "first knot"},
                     {"to", "rad, rad/s", 1.0, -1e9, 1e9, "last knot"},
                     {"knots", "1", 0.0, 0.0, kMostKnots, "how many there are"},
                     value}};
    info.learned = true;
    for (ParameterInfo& p : info.parameters) p.structural = !p.per_knot;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    int count = 0;  // lanes have the same knots or, in recordings in which it does not act, none
    for (int k = 0; k < kLanes<T>; ++k) count = std::max(count, static_cast<int>(lane(p[kKnots], k)));
    if (count < 2) return T(0.0);
    const T* value = p + kValues;
    const T x = min(max(select(p[kOver] > T(0.5), s.v, s.q), p[kFrom]), p[kTo]);
    const T at = (x - p[kFrom]) / (p[kTo] - p[kFrom]) * T(count - 1.0);  // in knots
    // Beyond either end one more knot stands on the line through the last two.
    T out = weight(at + T(1.0)) * (T(2.0) * value[0] - value[1]) +
            weight(at - T(count)) * (T(2.0) * value[count - 1] - value[count - 2]);
    for (int k = 0; k < count; ++k) out = out + weight(at - T(k)) * value[k];
    return out;
  }

  /// Keys' kernel, C1 and of third order; `distance` in knots.
  template <class T>
  static T weight(const T& distance) {
    const T x = abs(distance);
    const T near = T(1.0) + x * x * (T(1.5) * x - T(2.5));
    const T far = T(2.0) + x * (T(-4.0) + x * (T(2.5) - T(0.5) * x));
    return select(x < T(1.0), near, select(x < T(2.0), far, T(0.0)));
  }

 private:
  enum { kOver, kFrom, kTo, kKnots, kValues };
};

}  // namespace lacuna
