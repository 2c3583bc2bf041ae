// The readers behind load_recording, one per file format.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/recording.h"

namespace lacuna {

/// What messages say a recording may be.
inline const char* const kRecordingKinds = "a recording (.csv, .mat, or a bag of ROS 2: its folder, .db3 or .mcap)";

/// `name` is how messages call the file. Both throw InputError and nothing else for any content.
Recording read_csv(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits);
Recording read_mat(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits);

/// What load_recording does, before the result is shared.
Recording read_recording(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits,
                         const ColumnUse& use = {});

/// One recording of several files: where each lies, and what is said of it. The first file's clock is the recording's.
/// With one file that has one clock, its columns as they are; else all on that clock (clocks.h).
Recording read_recording(const std::vector<std::pair<std::filesystem::path, RecordingPart>>& parts,
                         const RecordingLimits& limits, const ColumnUse& use);

}  // namespace lacuna
