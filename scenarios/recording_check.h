// What a scenario asks of its recordings: columns, a clock, commands, positions.
#pragma once

#include "scenarios/scenario.h"

namespace lacuna {

/// Loads every recording once, checks it against channels and ranges, and leaves notes of what is missing in it.
/// Where the scenario names no time column, the first column of the recordings becomes it. Throws InputError.
void load_and_check_recordings(Scenario& scenario, const RecordingLimits& limits = {});

}  // namespace lacuna
