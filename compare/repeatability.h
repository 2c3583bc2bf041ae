// Whether an engine gives the same bits again.
#pragma once

#include "compare/comparison.h"
#include "compare/motion.h"

namespace lacuna {

/// Fills `repeats` and `restores` of the method: a motion run twice on one build, and run halfway, its (q, v) saved,
/// and continued from there on a fresh build. `motion` must have one phase and a plant without states (a free motion).
void measure_repeatability(const std::string& engine, const Motion& motion, double step, MethodResult& out);

}  // namespace lacuna
