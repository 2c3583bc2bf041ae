#include "scenarios/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
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

}  // namespace

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

void write_file_atomically(const fs::path& file, const std::string& text) {
  static std::atomic<unsigned> counter{0};
  fs::path part = file;
  part += fmt::format(".{}.{}.part", ::getpid(), counter++);
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  std::ofstream out(part, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (out) {
    error.clear();
    fs::rename(part, file, error);
    if (!error) return;
  }
  std::error_code ignored;
  fs::remove(part, ignored);
  throw WorkError("cannot write " + printable(file.string()) + ": " +
                  (error ? error.message() : std::string(std::strerror(errno))));
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
