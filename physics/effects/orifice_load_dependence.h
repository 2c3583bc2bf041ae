#pragma once

#include "physics/effects/oil_load.h"

namespace lacuna {

/// A valve's orifice passes oil as the square root of the pressure that is left across it: against its load a cylinder
/// goes slower, with it faster, and where the load takes up all of the supply's pressure it stands. Of a drive that
/// integrates its flow. Neutral at stall = infinity.
struct OrificeLoadDependence {
  static EffectInfo info() {
    EffectInfo info{"orifice_load_dependence",
                    "Load dependence of the valve's flow",
                    Where::joint,
                    Stage::flow,
                    "x' -> x' sqrt(1 - sgn(x') load/stall), load: effort of the oil spring; of a negative argument the "
                    "negative root",
                    "slower against the load, faster with it",
                    "valve_asymmetry, load_dependent_friction",
                    "turbulent orifice, load flow of a four-way valve: H. E. Merritt, Hydraulic Control Systems, 1967, "
                    "eq. 5-9",
                    {{"stall",
                      "N m",
                      HUGE_VAL,
                      1e-6,
                      HUGE_VAL,
                      "load that the supply's pressure cannot move",
                      Scale::effort,
                      {10.0, 3.0},
                      Coordinate::inverse}}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T taken(const T* p, const JointView<T>& s, const T& oil, const T& flow) {
    const T left = T(1.0) - sign(flow) * oil_load(s, oil) / p[0];
    return select(p[0] < T(HUGE_VAL), flow * root(left), flow);
  }

 private:
  /// sgn(x) sqrt|x|, made linear about 0, where orifices are laminar; 1 at 1.
  template <class T>
  static T root(const T& x) {
    constexpr double kLaminar = 0.01;  // of the supply's pressure: some 2 bar of 160
    const T scale = T(std::sqrt(std::sqrt(1.0 + kLaminar * kLaminar)));
    return scale * x / sqrt(sqrt(x * x + T(kLaminar * kLaminar)));
  }
};

}  // namespace lacuna
