// What free motion must keep: energy, the root joint's momentum, and the joints themselves.
#pragma once

#include "compare/comparison.h"
#include "compare/motion.h"
#include "compare/runner.h"

namespace lacuna {

/// Largest change of the total energy over the largest kinetic energy, by Featherstone's energy of the states.
double energy_drift(const Motion& motion, const Trajectory& run);

/// Of a motion without gravity: largest change of the root joint's momentum (M v)_0, which nothing can change since the
/// root's own coordinate is cyclic, over the largest sum of |M_0j v_j|.
double momentum_drift(const Motion& motion, const Trajectory& run);

/// Joint gaps of the engine's own bodies after the free motion at `step`, with and without correction; empty where the
/// engine's state is joint coordinates.
std::vector<JointDrift> joint_drift(const std::string& engine, const Motion& motion, double step);

}  // namespace lacuna
