// Recordings to be looked at after all is settled: measured, both models, and the effort that each lacks.
#pragma once

#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"

namespace lacuna {

/// Signals of `segments`, file by file and joint by joint: measured, and what both models predict.
std::vector<std::vector<Trace>> traces(const CurrentModel& before, const CurrentModel& after, const FitContext& context,
                                       const std::vector<int>& segments);

/// The first of the recordings in `found.predictions`, then those of the validate recordings that the findings' times
/// or those of the unexplained rest lie in, at most `kMostReplays` in all. Nothing is decided by them.
constexpr std::size_t kMostReplays = 3;
std::vector<Replay> replays(const Diagnosis& found, const CurrentModel& before, const CurrentModel& after,
                            const FitContext& context, const Scenario& scenario);

}  // namespace lacuna
