#pragma once

#include "physics/effects/learned_curve.h"

namespace lacuna {

/// What a valve or an amplifier adds to its command, and nobody wrote down.
struct LearnedCommand {
  static EffectInfo info() {
    return LearnedCurve::info("learned_command", "Learned command", Stage::command,
                              "u -> u + f(u), or of another variable; f by its values at knots", "V", Scale::command);
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u + LearnedCurve::at(p, s);
  }
};

}  // namespace lacuna
