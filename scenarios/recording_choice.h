// A recording named on the command line, loaded as the scenario's channels ask.
#pragma once

#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace lacuna {

/// The scenario's entry for a recording that the user names: as the scenario writes it, or a path from here or from the
/// scenario's folder; a file that the scenario does not list may lie anywhere. Where the scenario lists a file several
/// times, the entry covers all of its time ranges. Throws InputError.
RecordingSpec recording_named(const Scenario& scenario, const std::string& name);
/// All files that the scenario lists, in order, each once.
std::vector<RecordingSpec> recordings_of(const Scenario& scenario);

/// The scenario with this recording alone, loaded and checked, to be simulated from its start. Measured columns that
/// the file lacks (commands only) are added without values: such joints start at rest at 0.
Scenario with_recording(Scenario scenario, const RecordingSpec& spec);

}  // namespace lacuna
