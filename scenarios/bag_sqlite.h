// Messages out of a bag's SQLite database (`.db3`).
#pragma once

#include <filesystem>
#include <string>

#include "scenarios/recording.h"
#include "scenarios/topic_table.h"

namespace lacuna {

/// Adds what the tables `topics` and `messages` hold to `table`. `packed`: each message is a block of zstd (a bag
/// recorded with --compression-mode message). The file is opened for reading only, and nothing is written beside it;
/// one that was not closed (a write-ahead log beside it) is refused with the command that closes it. Bounded in size,
/// in steps and in bytes a message. Throws InputError. `shown` names the file.
void read_bag_sqlite(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits,
                     bool packed, TopicTable& table);

}  // namespace lacuna
