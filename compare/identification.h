// Data simulated by one engine, identified on another, for all pairs: what the choice of an engine costs.
#pragma once

#include <cstdint>
#include <functional>

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/motion.h"

namespace lacuna {

/// Every engine's data are its own: of its default integrator at `step` where it can carry the motion natively, else of
/// the common method. Every engine identifies with the same GA, seed and budget and a least-squares finish, by the
/// common method. Free are those parameters of the scenario's `identify` that belong to the joint that moves most.
/// `not_run` says why where there is nothing to identify. Throws Interrupted.
PairFits identify_pairs(const Scenario& scenario, const Motion& motion, const std::vector<std::string>& engines,
                        double step, std::uint64_t seed, int threads, const StopFlag* stop,
                        const std::function<void(double)>& progress);

}  // namespace lacuna
