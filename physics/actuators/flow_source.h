#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A valve's flow into a stiff cylinder, seen from outside: a velocity source behind a spring and damper.
/// State: x, the position that the oil would give an unloaded joint.
struct FlowSource {
  static constexpr int states = 1;
  static ActuatorInfo info() {
    return {"flow_source",
            "x' = gain u; tau = stiffness (x - q) + damping (x' - v)",
            "real valves on real cylinders",
            {{"gain", "rad/(s V)", std::nan(""), -1e9, 1e9,
              "speed per command (valve flow over displacement); negative: hoses swapped"},
             {"stiffness", "N m/rad", std::nan(""), 0.0, 1e12, "oil spring"},
             {"damping", "N m s/rad", std::nan(""), 0.0, 1e9, "damping across the oil spring"}},
            {.gain = 0, .damping = 2, .stiffness = 1},
            Stage::valve,
            true,
            states};
  }
  template <class T>
  static T flow(const T* p, const JointView<T>& s) {
    return p[0] * s.u;
  }
  template <class T>
  static void rate(const T*, const JointView<T>& s, T* out) {
    out[0] = s.flow;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return p[1] * (s.z[0] - s.q) + p[2] * (s.flow - s.v);
  }
  /// The oil spring carries the holding effort; the damper is taken to be at its steady motion (x' = v).
  template <class T>
  static void initial(const T* p, const JointView<T>& s, const T& holding, T* out) {
    out[0] = s.q + select(p[1] > T(0.0), holding / max(p[1], T(1e-300)), T(0.0));
  }
};

}  // namespace lacuna
