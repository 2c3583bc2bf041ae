// Reading and writing whole files, with the checks that keep hostile ones out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace lacuna {

/// A file that cannot be written (disk full, folder not writable): exit code 3 as well. No WorkError: where one fit of
/// many fails the others go on, but nothing goes on without its files.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether a file or folder of that name can be seen. A name that the system refuses (too long, a loop of links) is
/// none.
bool is_there(const std::filesystem::path& path);

/// Throws InputError unless `file` is a regular file (after symlinks) of at most `max_bytes`. `shown` names it in
/// messages, `what` says what was expected there ("a scenario file"). Devices and pipes are refused unopened.
std::uintmax_t check_regular_file(const std::filesystem::path& file, const std::string& shown, const std::string& what,
                                  std::uintmax_t max_bytes);

/// The whole text of a file that passes check_regular_file.
std::string read_text_file(const std::filesystem::path& file, const std::string& shown, const std::string& what,
                           std::uintmax_t max_bytes);

/// Writes beside `file` and renames, so that readers see the old text or the new one; on a full disk the old one stays.
/// `synced`: a loss of power leaves no torn file either. Makes missing folders. Throws WriteError, naming the file and
/// the system's reason.
void write_file_atomically(const std::filesystem::path& file, const std::string& text, bool synced = false);

/// The same with a copy of `source`.
void copy_file_atomically(const std::filesystem::path& source, const std::filesystem::path& target);

/// Throws WriteError; part of the text may then be in the file.
void append_to_file(const std::filesystem::path& file, const std::string& text);

/// Removes what processes that were killed while they wrote `file` left beside it.
void remove_leftovers(const std::filesystem::path& file);

/// Makes the folder where it is missing. Throws WriteError, also where files cannot be made in it: before the work
/// rather than after it.
void make_folder(const std::filesystem::path& folder);

/// Whether `path`, symlinks resolved as far as it exists, lies in the tree below `folder`.
bool inside(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace lacuna
