#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A transducer whose zero is elsewhere. Neutral at o = 0.
struct SensorOffset {
  static EffectInfo info() {
    return {"sensor_offset",
            "Sensor offset",
            Where::joint,
            Stage::reading,
            "reading = q + o",
            "a constant",
            "rest, valve_offset",
            "calibration of transducers",
            {{"o", "rad", 0.0, -7.0, 7.0, "reading at q = 0", Scale::position, {0.05}}}};
  }
  template <class T>
  static void sense(const T* p, const std::vector<T>& time, T* q, std::size_t stride) {
    for (std::size_t k = 0; k < time.size(); ++k) q[k * stride] = q[k * stride] + p[0];
  }
  template <class T>
  static T unsense(const T* p, const T& q) {
    return q - p[0];
  }
};

}  // namespace lacuna
