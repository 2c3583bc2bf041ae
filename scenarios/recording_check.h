// What a scenario asks of its recordings: columns, a clock, commands, positions.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "scenarios/scenario.h"

namespace lacuna {

/// What the scenario's channels are for.
ColumnUse column_use(const ChannelSpecs& channels);

/// The files that an entry names, and where they lie.
std::vector<std::pair<std::filesystem::path, RecordingPart>> parts_of(const Scenario& scenario,
                                                                      const RecordingSpec& spec);

/// Loads every recording once, checks it against channels and ranges, and leaves notes of what is missing in it.
/// Where the scenario names no time column, the first column of the recordings becomes it. Throws InputError.
void load_and_check_recordings(Scenario& scenario, const RecordingLimits& limits = {});

}  // namespace lacuna
