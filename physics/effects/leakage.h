#pragma once

#include "physics/actuators/hydraulic.h"
#include "physics/effects/oil_load.h"

namespace lacuna {

/// Oil passes the piston's seals from the loaded chamber to the other: a joint under load sinks, and is slower against
/// its load. Of a drive that integrates its flow, or has chambers. Neutral at R = infinity.
struct Leakage {
  static EffectInfo info() {
    EffectInfo info{"leakage",
                    "Leakage past the piston",
                    Where::joint,
                    Stage::flow,
                    "x' -> x' - load/R, load: effort of the oil spring",
                    "creep under load at rest",
                    "valve_offset, orifice_load_dependence",
                    "laminar leakage of a piston: H. E. Merritt, Hydraulic Control Systems, 1967, eq. 6-4",
                    {{"R",
                      "N m s/rad",
                      HUGE_VAL,
                      1e-9,
                      HUGE_VAL,
                      "load that makes the joint creep at unit speed",
                      Scale::damping,
                      {30.0, 3.0},
                      Coordinate::inverse}}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T taken(const T* p, const JointView<T>& s, const T& oil, const T& flow) {
    return flow - oil_load(s, oil) / p[0];
  }
  static void chambers(const double* p, double* actuator) { Hydraulic::leak(actuator, p[0]); }
};

}  // namespace lacuna
