#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A transducer of another sensitivity. Neutral at s = 0.
struct SensorScale {
  static EffectInfo info() {
    return {"sensor_scale",
            "Sensor scale",
            Where::joint,
            Stage::reading,
            "reading = (1 + s) q",
            "an error in proportion to the angle",
            "gain, stiffness",
            "calibration of transducers",
            {{"s", "1", 0.0, -0.9, 10.0, "error of the sensitivity", Scale::ratio, {0.02}}}};
  }
  template <class T>
  static void sense(const T* p, const std::vector<T>& time, T* q, std::size_t stride) {
    for (std::size_t k = 0; k < time.size(); ++k) q[k * stride] = (T(1.0) + p[0]) * q[k * stride];
  }
  template <class T>
  static T unsense(const T* p, const T& q) {
    return q / (T(1.0) + p[0]);
  }
};

}  // namespace lacuna
