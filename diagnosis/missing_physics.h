// The search for what is missing of a simulated motion: one effect a round (rounds.h), then sets of them where a rest
// remains (set_search.h). A machine whose joints cannot all move each other is taken apart first (parts.h), unless a
// single effect of the whole arm leaves nothing to explain; what acts on the whole arm beside the parts' own effects is
// looked for when they are together again.
#pragma once

#include "diagnosis/checkpoint.h"
#include "diagnosis/diagnosis.h"
#include "diagnosis/rounds.h"

namespace lacuna {

struct MissingPhysics {
  CurrentModel model;     ///< with all that was found, fitted
  double max_step = 0.0;  ///< s, that it was fitted at
  StepChoice step;        ///< that it needs
};

/// From `before`, the plain model as identified and arrived at the context's step. Findings, candidates and notes go to
/// `out`, whose `before` and `missing` are filled in already.
MissingPhysics search_missing_physics(const Scenario& scenario, const FitContext& context, const CurrentModel& before,
                                      DiagnosisCheckpoint& saved, Diagnosis& out, const Report& report);

}  // namespace lacuna
