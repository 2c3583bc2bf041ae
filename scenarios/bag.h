// Bags of ROS 2: a folder with metadata.yaml and the files that it lists, or one such file alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/clocks.h"
#include "scenarios/recording.h"

namespace lacuna {

/// Whether a path is a bag by its looks: a folder, or a name ending in .db3 or .mcap.
bool is_bag(const std::filesystem::path& path);

/// The files that a recording consists of: a bag's folder stands for metadata.yaml and the files it lists, anything
/// else for itself. Throws InputError for a folder that is no bag, for files it lists that are missing or lie outside
/// of it, and for bags whose files are compressed as a whole, with the command that unpacks them.
std::vector<std::filesystem::path> recording_files(const std::filesystem::path& recording, const std::string& shown);

/// Copies the files of a recording, a bag's folder as a folder. Throws WriteError where that cannot be done.
void copy_recording(const std::filesystem::path& source, const std::filesystem::path& target);

/// Every topic that can be read, with its own clock. Throws InputError and nothing else for any content.
TrackSet read_bag(const std::filesystem::path& path, const std::string& shown, const RecordingLimits& limits,
                  bool log_times);

}  // namespace lacuna
