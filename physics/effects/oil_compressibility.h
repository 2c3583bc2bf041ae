#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The oil of a cylinder is a spring that is stiffer towards either end of the stroke, where one of the chambers holds
/// little: with the piston at a share r of half its stroke from the middle, the two chambers together are
/// 1/(1 - r^2) times as stiff as at the middle (B A^2 (1/V_A + 1/V_B), no dead volumes). The load grows by what the
/// valve gives beyond what the piston sweeps. Of a drive that integrates its flow; its `stiffness` is that at the
/// middle. Neutral at half = infinity.
struct OilCompressibility {
  static EffectInfo info() {
    EffectInfo info{"oil_compressibility",
                    "Compressibility of the oil",
                    Where::joint,
                    Stage::flow,
                    "x' -> v + (x' - v)/(1 - r^2), r = (q - middle)/half",
                    "a ringing that is faster towards the ends of the stroke",
                    "stiffness_hardening, actuator_lag",
                    "hydraulic spring of a cylinder: H. E. Merritt, Hydraulic Control Systems, 1967, eq. 6-15; M. "
                    "Jelali, A. Kroll, Hydraulic Servo-systems, 2003, ch. 4",
                    {{"half",
                      "rad",
                      HUGE_VAL,
                      1e-6,
                      HUGE_VAL,
                      "half of the stroke, as a way of the joint",
                      Scale::travel,
                      {1.0, 0.6},
                      Coordinate::inverse},
                     {"middle", "rad", 0.0, -1e3, 1e3, "position at half of the stroke", Scale::reach, {0.0}}}};
    info.hydraulic = true;
    // Ringing is faster than positions are sampled; sought in them, steps that cannot follow it pass for evidence.
    info.in_efforts = true;
    return info;
  }
  template <class T>
  static T taken(const T* p, const JointView<T>& s, const T&, const T& flow) {
    const T share = (s.q - p[1]) / p[0];
    const T left = max(T(1.0) - share * share, T(kLeast));
    return select(p[0] < T(HUGE_VAL), s.v + (flow - s.v) / left, flow);
  }

 private:
  static constexpr double kLeast = 0.05;  ///< of 1 - r^2: hoses and ports hold oil at the end of the stroke, too
};

}  // namespace lacuna
