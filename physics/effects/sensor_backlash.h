#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Play between joint and transducer: the motion is right, the reading stands after each reversal. Neutral at h = 0.
struct SensorBacklash {
  static EffectInfo info() {
    return {"sensor_backlash",
            "Sensor backlash",
            Where::joint,
            Stage::reading,
            "reading = play of half-width h on q",
            "the reading is flat after reversals while the motion goes on",
            "backlash",
            "M. Brokate and J. Sprekels, Hysteresis and Phase Transitions, 1996, ch. 2 (play operator)",
            {{"h", "rad", 0.0, 0.0, 10.0, "half-width of the play", Scale::position, {0.01, 0.05}}}};
  }
  template <class T>
  static void sense(const T* p, const std::vector<T>& time, T* q, std::size_t stride) {
    T reading = q[0];
    for (std::size_t k = 0; k < time.size(); ++k) {
      reading = max(min(reading, q[k * stride] + p[0]), q[k * stride] - p[0]);
      q[k * stride] = reading;
    }
  }
};

}  // namespace lacuna
