// The readers behind load_recording, one per file format.
#pragma once

#include <filesystem>
#include <string>

#include "scenarios/recording.h"

namespace lacuna {

/// `name` is how messages call the file. Both throw InputError and nothing else for any content.
Recording read_csv(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits);
Recording read_mat(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits);

/// What load_recording does, before the result is shared.
Recording read_recording(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits);

}  // namespace lacuna
