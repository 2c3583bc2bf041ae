// Reading and writing whole files, with the checks that keep hostile ones out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace lacuna {

/// Throws InputError unless `file` is a regular file (after symlinks) of at most `max_bytes`. `shown` names it in
/// messages, `what` says what was expected there ("a scenario file"). Devices and pipes are refused unopened.
std::uintmax_t check_regular_file(const std::filesystem::path& file, const std::string& shown, const std::string& what,
                                  std::uintmax_t max_bytes);

/// The whole text of a file that passes check_regular_file.
std::string read_text_file(const std::filesystem::path& file, const std::string& shown, const std::string& what,
                           std::uintmax_t max_bytes);

/// Writes beside `file` and renames, so that readers see the old text or the new one. Throws WorkError.
void write_file_atomically(const std::filesystem::path& file, const std::string& text);

/// Whether `path`, symlinks resolved as far as it exists, lies in the tree below `folder`.
bool inside(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace lacuna
