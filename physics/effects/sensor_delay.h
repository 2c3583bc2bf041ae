#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A reading that comes late: cubic interpolation between samples; before the first one the reading stands. Neutral at
/// 0.
struct SensorDelay {
  static EffectInfo info() {
    return {"sensor_delay",
            "Sensor delay",
            Where::joint,
            Stage::reading,
            "reading = q(t - T)",
            "a lag of one joint's reading; its neighbours feel none",
            "input_delay",
            "filtering and bus latency of transducers",
            {{"T", "s", 0.0, 0.0, 1.0, "delay", Scale::time, {0.005, 0.03}}}};
  }
  template <class T>
  static void sense(const T* p, const std::vector<T>& time, T* q, std::size_t stride) {
    const std::vector<T> whole = copied(q, time.size(), stride);
    for (int lane_index = 0; lane_index < kLanes<T>; ++lane_index) {
      const double late = lane(p[0], lane_index);
      if (!(late > 0.0)) continue;
      std::size_t i = 0;
      for (std::size_t k = 0; k < time.size(); ++k) {
        const double t = lane(time[k], lane_index) - late;
        while (i + 1 < time.size() && lane(time[i + 1], lane_index) <= t) ++i;
        set_lane(q[k * stride], lane_index, between(whole, time, i, t, lane_index));
      }
    }
  }

 private:
  template <class T>
  static std::vector<T> copied(const T* q, std::size_t n, std::size_t stride) {
    std::vector<T> out;
    for (std::size_t k = 0; k < n; ++k) out.push_back(q[k * stride]);
    return out;
  }
  /// Hermite's cubic through samples i and i + 1, slopes by central differences.
  template <class T>
  static double between(const std::vector<T>& q, const std::vector<T>& time, std::size_t i, double t, int k) {
    const std::size_t n = time.size();
    if (t <= lane(time.front(), k) || n < 2) return lane(q.front(), k);
    if (i + 1 >= n) return lane(q.back(), k);
    const auto slope = [&](std::size_t at) {
      const std::size_t a = at > 0 ? at - 1 : at, b = at + 1 < n ? at + 1 : at;
      return (lane(q[b], k) - lane(q[a], k)) / (lane(time[b], k) - lane(time[a], k));
    };
    const double begin = lane(time[i], k), h = lane(time[i + 1], k) - begin, s = (t - begin) / h, r = 1.0 - s;
    return r * r * ((1.0 + 2.0 * s) * lane(q[i], k) + s * h * slope(i)) +
           s * s * ((1.0 + 2.0 * r) * lane(q[i + 1], k) - r * h * slope(i + 1));
  }
};

}  // namespace lacuna
