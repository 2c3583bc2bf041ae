#pragma once

#include "physics/effects/learned_curve.h"

namespace lacuna {

/// What a valve or an amplifier adds to its command, and nobody wrote down.
struct LearnedCommand {
  static EffectInfo info() {
    EffectInfo info{"learned_command",
                    "Learned command",
                    Where::joint,
                    Stage::command,
                    "u -> u + f(u), or of another variable of the joint; f through its values at knots",
                    "whatever it was learned from",
                    "nothing that has a name",
                    "cubic convolution: R. G. Keys, IEEE Trans. ASSP 29 (1981)",
                    LearnedCurve::parameters("V", Scale::command)};
    info.learned = true;
    return info;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u + LearnedCurve::at(p, s);
  }
};

}  // namespace lacuna
