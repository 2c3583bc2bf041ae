#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A cylinder on a lever pulls with an arm that varies with the angle; its first harmonic. It makes the joint's
/// effort from the cylinder's force, before an effort that is measured. Neutral at ratio = 0.
struct LeverArmVariation {
  static EffectInfo info() {
    EffectInfo info{"lever_arm_variation",
                    "Lever arm variation",
                    Where::joint,
                    Stage::effort,
                    "u -> u (1 + ratio (sin(q + phase) - sin(phase)))",
                    "the gain depends on the angle",
                    "gravity, stiffness_hardening",
                    "law of sines at a cylinder on a lever, r = a b sin(phi)/c, to the first harmonic of the angle",
                    {{"ratio", "1", 0.0, 0.0, 10.0, "variation over the arm at zero angle", Scale::ratio, {0.3}},
                     {"phase",
                      "rad",
                      0.0,
                      -7.0,
                      7.0,
                      "angle of the variation at zero joint angle",
                      Scale::ratio,
                      {0.0, 1.5, 3.1, -1.5}}}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    T sine, cosine, sine0;
    sincos(s.q + p[1], sine, cosine);
    sincos(p[1], sine0, cosine);
    return s.u * (T(1.0) + p[0] * (sine - sine0));
  }
};

}  // namespace lacuna
