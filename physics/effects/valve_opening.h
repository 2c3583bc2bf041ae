#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A metering edge that opens gradually: beside a slot, whose area grows with the spool's way, a triangular notch,
/// whose area grows with its square. The gain is that of a slot alone which passes as much at the command `full`.
/// Neutral at c = 0; a notch alone is c = 1, and beyond it nothing passes before the notch is well open.
struct ValveOpening {
  static EffectInfo info() {
    ParameterInfo full{"full",        "V", 1.0, 1e-6, 1e6, "command, beyond the dead zone, to which the gain belongs",
                       Scale::command};
    full.structural = true;
    EffectInfo info{
        "valve_opening",
        "Progressive valve opening",
        Where::joint,
        Stage::valve,
        "u -> u max(1 - c + c |u|/full, 0)",
        "small commands do less than their share",
        "valve_deadband, gain",
        "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 5 (areas of slots and notches)",
        {{"c", "1", 0.0, 0.0, 2.0, "share of the notch in what passes at that command", Scale::ratio, {0.4, 1.0}},
         full}};
    info.hydraulic = true;
    info.metering = true;
    return info;
  }
  static constexpr bool curve = true;
  template <class T>
  static T command(const T* p, const JointView<T>& s) {
    return s.u * max(T(1.0) - p[kC] + p[kC] * abs(s.u) / p[kFull], T(0.0));
  }

 private:
  enum { kC, kFull };
};

}  // namespace lacuna
