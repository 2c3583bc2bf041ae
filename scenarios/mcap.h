// Messages out of a file in MCAP, version 0 (mcap.dev/spec).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/recording.h"
#include "scenarios/topic_table.h"

namespace lacuna {

/// Adds what the file's data section holds to `table`, chunks unpacked (none, lz4, zstd) and their checksums and the
/// section's checked where they are given; the summary is not needed. A file that ends before its data section does was
/// cut off while it was written: its whole records are used, and a note says at which byte it ends. Everything else
/// that is not as specified is an InputError with the byte at which its record begins. `shown` names the file.
void read_mcap(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits,
               TopicTable& table, std::vector<std::string>& notes);

}  // namespace lacuna
