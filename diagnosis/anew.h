// What is said of findings, once it is settled which they are.
#pragma once

#include <cstdint>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Everything that is said of each finding, beside the others as they stand now: probability, rivals and class among
/// its rivals in its place; gain on the validate recordings, chance corrected for `tries` candidates, stability against
/// none, times and regions over the model that is re-identified without it. In the round that found it others were
/// still missing, or stood there that have been exchanged or taken out since. Where the motion cannot be simulated
/// without a finding, the second half stays what it was. `plain`, `current`, `findings` as in without.h.
void judge_anew(const CurrentModel& plain, const CurrentModel& current, std::vector<Finding>& findings,
                const FitContext& context, int tries, std::uint64_t seed);

}  // namespace lacuna
