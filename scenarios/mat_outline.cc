#include "scenarios/mat_outline.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::uintmax_t kHeaderBytes = 128;
constexpr std::uint32_t kMatrix = 14, kCompressed = 15;
const char* const kExpected = "a MATLAB file of version 5 or 7 (save -v7)";

std::uint32_t to_uint32(const unsigned char* bytes, bool big_endian) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= std::uint32_t{bytes[big_endian ? 3 - i : i]} << (8 * i);
  return value;
}

}  // namespace

void check_mat_outline(const std::filesystem::path& file, const std::string& name) {
  const std::string where = printable(name);
  const std::uintmax_t size = std::filesystem::file_size(file);
  std::ifstream stream(file, std::ios::binary);
  std::array<unsigned char, kHeaderBytes> header{};
  if (!stream.read(reinterpret_cast<char*>(header.data()), kHeaderBytes))
    throw InputError(where, fmt::format("{} bytes", size), kExpected);
  const bool big_endian = header[126] == 'M' && header[127] == 'I';
  if (!big_endian && !(header[126] == 'I' && header[127] == 'M'))
    throw InputError(where, "no MATLAB 5 header", kExpected);
  const int version = big_endian ? header[124] << 8 | header[125] : header[125] << 8 | header[124];
  if (version == 0x0200) throw InputError(where, "a MATLAB 7.3 file (HDF5)", kExpected);
  if (version != 0x0100) throw InputError(where, fmt::format("format version 0x{:04x}", version), kExpected);

  std::uintmax_t at = kHeaderBytes;
  while (at < size) {
    std::array<unsigned char, 8> tag{};
    if (!stream.seekg(static_cast<std::streamoff>(at)) || !stream.read(reinterpret_cast<char*>(tag.data()), 8))
      throw InputError(where, fmt::format("an element cut at byte {}", at), "a whole file");
    const std::uint32_t type = to_uint32(tag.data(), big_endian);
    const std::uint32_t bytes = to_uint32(tag.data() + 4, big_endian);
    if (type != kMatrix && type != kCompressed)
      throw InputError(where, fmt::format("an element of type {} at byte {}", type, at), "variables");
    if (bytes > size - at - 8)
      throw InputError(where, fmt::format("a variable of {} bytes at byte {} of {}", bytes, at, size), "a whole file");
    at += 8 + std::uintmax_t{bytes};
  }
}

}  // namespace lacuna
