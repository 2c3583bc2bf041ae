#pragma once

#include "physics/actuators/hydraulic.h"
#include "physics/effects/oil_load.h"

namespace lacuna {

/// Relief valves at a cylinder's ports: beyond the load at which they open, the valve's flow leaves through them, and
/// so does the oil that a load from outside presses out. Of a drive that integrates its flow, or has chambers: there
/// they open at the pressure at which either chamber alone gives that load. Neutral at most = infinity.
struct Relief {
  static EffectInfo info() {
    EffectInfo info{"relief",
                    "Relief valve",
                    Where::joint,
                    Stage::flow,
                    "x' -> x' - sgn(load) max(|load| - most, 0)/(T stiffness), load: effort of the oil spring, T: 1 ms",
                    "a joint that stands, or gives way, beyond one load",
                    "orifice_load_dependence, end_stop",
                    "direct-acting relief valve: H. E. Merritt, Hydraulic Control Systems, 1967, ch. 9",
                    {{"most",
                      "N m",
                      HUGE_VAL,
                      1e-6,
                      HUGE_VAL,
                      "load at which the relief valves open",
                      Scale::effort,
                      {3.0, 1.0},
                      Coordinate::inverse}}};
    info.hydraulic = true;
    return info;
  }
  /// What is too much leaves within the time that a relief valve takes to open, or in the shortest that the steps can
  /// follow.
  template <class T>
  static T taken(const T* p, const JointView<T>& s, const T& oil, const T& flow) {
    const T load = oil_load(s, oil), beyond = max(abs(load) - p[0], T(0.0));
    const T passes = sign(load) * beyond / (max(s.stiffness, T(1e-300)) * max(s.resolved, T(kReliefOpens)));
    return select(beyond > T(0.0), flow - passes, flow);
  }
  static void chambers(const double* p, double* actuator) { Hydraulic::relieve(actuator, p[0]); }
};

}  // namespace lacuna
