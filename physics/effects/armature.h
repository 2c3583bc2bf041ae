#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Inertia that turns with the motor, reflected to the joint: felt in the joint's own acceleration only. Neutral at 0.
struct Armature {
  static EffectInfo info() {
    return {"armature",
            "Armature",
            Where::joint,
            Stage::link,
            "tau -= J a at the joint",
            "phase at high acceleration, one joint only",
            "actuator_lag, masses",
            "R. Featherstone, Rigid Body Dynamics Algorithms, 2008, sec. 9.6 (rotors)",
            {{"J", "kg m^2", 0.0, 0.0, 1e9, "reflected inertia", Scale::inertia, {0.1}}}};
  }
  static double armature(const double* p) { return p[0]; }
};

}  // namespace lacuna
