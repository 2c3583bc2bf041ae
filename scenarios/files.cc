#include "scenarios/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string_view>
#include <system_error>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

std::string kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory: return "a folder";
    case fs::file_type::fifo: return "a pipe";
    case fs::file_type::socket: return "a socket";
    case fs::file_type::character:
    case fs::file_type::block: return "a device";
    default: return "something that is no regular file";
  }
}

std::error_code last_error() { return {errno, std::generic_category()}; }

[[noreturn]] void fail_to_write(const fs::path& file, const std::error_code& error) {
  throw WriteError("cannot write " + printable(file.string()) + ": " + error.message());
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

std::error_code write_all(int out, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(out, text.data(), text.size());
    if (n < 0 && errno != EINTR) return last_error();
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

/// Opens the file, has it filled, and closes it: a disk may say only then that it is full.
std::error_code write_out(const fs::path& file, int mode, const std::function<std::error_code(int out)>& fill) {
  const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | mode, 0666);
  if (out < 0) return last_error();
  std::error_code error = fill(out);
  if (::close(out) != 0 && !error) error = last_error();
  return error;
}

/// Not std::filesystem::copy_file, whose reason for a full disk is "Input/output error".
std::error_code copy_all(const fs::path& source, int out) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(source.c_str(), "rb"), &std::fclose);
  if (!in) return last_error();
  std::string block(std::size_t{1} << 20, '\0');
  while (const std::size_t n = std::fread(block.data(), 1, block.size(), in.get()))
    if (const std::error_code error = write_all(out, std::string_view(block).substr(0, n))) return error;
  return std::ferror(in.get()) != 0 ? std::make_error_code(std::errc::io_error) : std::error_code();
}

/// Makes a renaming survive a loss of power. Some file systems cannot sync a folder; that is no error.
void sync_folder(const fs::path& folder) {
  const int in = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (in < 0) return;
  ::fsync(in);
  ::close(in);
}

/// Has a file made beside `file`, then renames it; where either fails, all is as it was.
void replace_file(const fs::path& file, const std::function<std::error_code(const fs::path& part)>& make) {
  static std::atomic<unsigned> counter{0};
  std::error_code error, ignored;
  fs::create_directories(folder_of(file), ignored);  // without it, making the file says why
  remove_leftovers(file);
  fs::path part = file;
  part += fmt::format(".{}.{}.part", ::getpid(), counter++);
  error = make(part);
  if (!error) fs::rename(part, file, error);
  if (!error) return;
  fs::remove(part, ignored);
  fail_to_write(file, error);
}

}  // namespace

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) && !error;
}

std::uintmax_t check_regular_file(const fs::path& file, const std::string& shown, const std::string& what,
                                  std::uintmax_t max_bytes) {
  const std::string where = printable(shown);
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) throw InputError(where, "no such file", what);
  if (error) throw InputError(where, error.message(), what);
  if (status.type() != fs::file_type::regular) throw InputError(where, kind_of(status.type()), what);
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) throw InputError(where, error.message(), what);
  if (bytes == 0) throw InputError(where, "an empty file", what);
  if (bytes > max_bytes)
    throw InputError(where, fmt::format("{} bytes", bytes), fmt::format("{} of at most {} bytes", what, max_bytes));
  return bytes;
}

std::string read_text_file(const fs::path& file, const std::string& shown, const std::string& what,
                           std::uintmax_t max_bytes) {
  const std::uintmax_t bytes = check_regular_file(file, shown, what, max_bytes);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) throw InputError(printable(shown), std::strerror(errno), what);
  std::string text(bytes, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), stream.get()));
  if (std::ferror(stream.get()) != 0) throw InputError(printable(shown), "a read error", what);
  return text;
}

void write_file_atomically(const fs::path& file, const std::string& text, bool synced) {
  replace_file(file, [&](const fs::path& part) {
    return write_out(part, O_TRUNC, [&](int out) {
      const std::error_code error = write_all(out, text);
      return !error && synced && ::fsync(out) != 0 ? last_error() : error;
    });
  });
  if (synced) sync_folder(folder_of(file));
}

void copy_file_atomically(const fs::path& source, const fs::path& target) {
  replace_file(target, [&](const fs::path& part) {
    return write_out(part, O_TRUNC, [&](int out) { return copy_all(source, out); });
  });
}

void append_to_file(const fs::path& file, const std::string& text) {
  const std::error_code error = write_out(file, O_APPEND, [&](int out) { return write_all(out, text); });
  if (error) fail_to_write(file, error);
}

void remove_leftovers(const fs::path& file) {
  const std::string begin = file.filename().string() + ".", end = ".part";
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_of(file), ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(begin) || !name.ends_with(end)) continue;
    const long writer = std::strtol(name.c_str() + begin.size(), nullptr, 10);
    if (writer > 0 && ::kill(static_cast<pid_t>(writer), 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
  }
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder)) error = std::make_error_code(std::errc::not_a_directory);
  if (error) throw WriteError("cannot make the folder " + printable(folder.string()) + ": " + error.message());
  // Asks the system rather than the modes: a mounted image may be read-only whatever they say.
  if (::access(folder.c_str(), W_OK | X_OK) != 0) fail_to_write(folder, last_error());
}

bool inside(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error) return false;
  // Made absolute first: what does not exist stays relative otherwise, and is inside nothing.
  const fs::path target = fs::weakly_canonical(fs::absolute(path), error);
  if (error) return false;
  const auto [end, unused] = std::mismatch(root.begin(), root.end(), target.begin(), target.end());
  return end == root.end();
}

}  // namespace lacuna
