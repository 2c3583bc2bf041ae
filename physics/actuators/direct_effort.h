#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Recordings whose command is a measured force, torque or motor current.
struct DirectEffort {
  static ActuatorInfo info() {
    return {"direct_effort",
            "tau = gain u - damping v",
            "measured force, torque or motor current",
            {{"gain", "N m/V", std::nan(""), -1e9, 1e9, "effort per command; negative: the other sign convention"},
             {"damping", "N m s/rad", 0.0, 0.0, 1e9, "viscous damping"}},
            {.gain = 0, .damping = 1},
            Stage::effort};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return p[0] * s.u - p[1] * s.v;
  }
  template <class T>
  static T loss(const T* p) {
    return p[1];
  }
};

}  // namespace lacuna
