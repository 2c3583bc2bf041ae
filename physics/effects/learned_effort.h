#pragma once

#include "physics/effects/learned_curve.h"

namespace lacuna {

/// An effort that nobody wrote down.
struct LearnedEffort {
  static EffectInfo info() {
    return LearnedCurve::info("learned_effort", "Learned effort", Stage::link,
                              "tau += f(x) or f(x, y): positions, speeds, the command, time; f by its values at knots",
                              "N m", Scale::effort);
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return LearnedCurve::at(p, s);
  }
};

}  // namespace lacuna
