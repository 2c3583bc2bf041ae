// What an engine costs: an evaluation, a step, a change of parameters, a build, memory. Timings of all engines are
// interleaved, so that whatever else the machine does falls on all alike.
#pragma once

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/motion.h"
#include "compare/runner.h"

namespace lacuna {

/// Fills forward_ns, set_inertial_ns, build_us and memory_bytes of every engine that is available.
void measure_engine_costs(const Motion& motion, std::uint64_t seed, std::vector<EngineComparison>& engines,
                          const StopFlag* stop);

/// Fills ns_per_step and realtime_factor of every method that was run, and from them the work points' computing times,
/// at `step` over the motion that the runners run. `runners`: one per engine, null where it is not available.
void measure_step_costs(std::vector<std::unique_ptr<Runner>>& runners, double step,
                        std::vector<EngineComparison>& engines, const StopFlag* stop);

}  // namespace lacuna
