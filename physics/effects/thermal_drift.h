#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Oil and grease that warm: damping falls towards a lower value over the session, one recording after the other. What
/// drifts is lost as friction is, behind an effort that is measured. Neutral at depth = 0.
struct ThermalDrift {
  static EffectInfo info() {
    return {"thermal_drift",
            "Thermal drift",
            Where::joint,
            Stage::link,
            "damping -> (1 - depth (1 - exp(-t/tau))) damping, t from the start of the session",
            "a residual that grows or fades with time",
            "damping",
            "viscosity over temperature (C. Walther 1931), first-order warming",
            {{"depth", "1", 0.0, -5.0, 1.0, "share of the damping lost in the end", Scale::ratio, {0.2}},
             {"tau", "s", 10.0, 1e-2, 1e6, "time constant of the warming", Scale::span, {0.4, 2.0}}}};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return p[0] * (T(1.0) - exp(T(0.0) - min(s.t / p[1], T(700.0)))) * s.damping * s.v;
  }
};

}  // namespace lacuna
