// Step 5: the found model on recordings that were never used, on the identifying engine and on every other one.
#pragma once

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"

namespace lacuna {

/// Fills `engines` (residual before and after on the test recordings, engine by engine, same parameters), `whiteness`
/// and `traces`.
void verify(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const Experiment& experiment,
            const SimulatorOptions& options, bool other_engines);

}  // namespace lacuna
