// Where in time and state an effect that was found removes residual, for the eye: shares, not tests.
#pragma once

#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Fills finding.times (the seconds of the validate recordings in which it removes most, at most three) and
/// finding.regions (those in which it removes a larger share than they are long, at most three, most telling first).
/// Nothing where the prediction is inverse dynamics or there is no validate recording.
void describe_evidence(Finding& finding, const CurrentModel& before, const CurrentModel& after,
                       const FitContext& context);

}  // namespace lacuna
