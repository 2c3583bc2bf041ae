#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Play in the valve's linkage or its magnet: the spool follows the command once it has moved by h. Neutral at h = 0.
struct ValveHysteresis {
  static EffectInfo info() {
    EffectInfo info{"valve_hysteresis",
                    "Valve hysteresis",
                    Where::joint,
                    Stage::valve,
                    "play of half-width h on u",
                    "a loop in the response against the command",
                    "valve_deadband, backlash",
                    "M. Brokate and J. Sprekels, Hysteresis and Phase Transitions, 1996, ch. 2 (play operator)",
                    {{"h", "V", 0.0, 0.0, 1e6, "half-width of the play", Scale::command, {0.03, 0.12}}}};
    info.hydraulic = true;
    return info;
  }
  static constexpr int memories = 1;
  template <class T>
  static void begin(const T*, const JointView<T>& s, const T&, T* now) {
    now[0] = s.u;
  }
  template <class T>
  static void remember(const T* p, const JointView<T>& s, const T&, const T* before, T* now) {
    now[0] = max(min(before[0], s.u + p[0]), s.u - p[0]);
  }
  template <class T>
  static T command(const T*, const JointView<T>& s) {
    return s.m[0];
  }
};

}  // namespace lacuna
