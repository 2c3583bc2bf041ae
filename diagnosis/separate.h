// The next experiment: where the recordings do not separate the members of a class, the motion that would.
//
// Candidates are drawn courses of all commands (physics/course.h), weakened until the found model keeps to the limits
// of the recordings. The found model's motion is what would be recorded; each rival is re-identified on it together
// with the train recordings (linearised about its own fit). What it then still misses, in units of the noise, is what
// would speak against it: half the squares are the log-likelihood to be expected. The motion whose hardest rival is
// easiest is proposed, after a small evolution.
#pragma once

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"

namespace lacuna {

/// One Separation for every finding whose class has more than one member, put into it. `plain` is the model without
/// findings, `current` the one with all of them. Findings on inverse dynamics, or where nothing is commanded, get none.
void separate(std::vector<Finding>& findings, const CurrentModel& plain, const CurrentModel& current,
              const FitContext& context, std::uint64_t seed);

}  // namespace lacuna
