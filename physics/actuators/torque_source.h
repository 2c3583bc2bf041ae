#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The seed paper's joint: the whole electro-hydraulic block as one gain on a damped spring.
struct TorqueSource {
  static ActuatorInfo info() {
    return {"torque_source",
            "tau = gain u - damping v - stiffness (q - rest)",
            "the seed's nine-parameter model",
            {{"gain", "N m/V", std::nan(""), -1e9, 1e9, "effort per command; negative: hoses swapped"},
             {"damping", "N m s/rad", std::nan(""), 0.0, 1e9, "viscous damping"},
             {"stiffness", "N m/rad", std::nan(""), 0.0, 1e12, "spring towards rest"},
             {"rest", "rad", 0.0, -1e3, 1e3, "position at which the spring is slack"}},
            {.gain = 0, .damping = 1, .stiffness = 2, .rest = 3},
            Stage::valve,
            true};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return p[0] * s.u - p[1] * s.v - p[2] * (s.q - p[3]);
  }
  template <class T>
  static T loss(const T* p) {
    return p[1];
  }
};

}  // namespace lacuna
