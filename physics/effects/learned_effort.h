#pragma once

#include "physics/effects/learned_curve.h"

namespace lacuna {

/// An effort that nobody wrote down.
struct LearnedEffort {
  static EffectInfo info() {
    EffectInfo info{"learned_effort",
                    "Learned effort",
                    Where::joint,
                    Stage::link,
                    "tau += f(x) or f(x, y): positions, speeds, the command, time; f through its values at knots",
                    "whatever it was learned from",
                    "nothing that has a name",
                    "cubic convolution: R. G. Keys, IEEE Trans. ASSP 29 (1981)",
                    LearnedCurve::parameters("N m", Scale::effort)};
    info.learned = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return LearnedCurve::at(p, s);
  }
};

}  // namespace lacuna
