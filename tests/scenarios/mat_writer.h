// MATLAB 5 files for tests, built byte by byte so that anything in them may lie.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace lacuna::test {

/// Builds a file element by element; dimensions may lie.
class MatWriter {
 public:
  explicit MatWriter(bool big_endian) : big_endian_(big_endian) {
    bytes_ = "MATLAB 5.0 MAT-file";
    bytes_.resize(124, ' ');
    put<std::uint16_t>(0x0100);
    put<std::uint16_t>(0x4D49);  // "MI"
  }

  /// A column vector; `array_class` (6 double ... 13 uint32) and `data_type` (9 double, 7 single, 1 int8 ...) as in the
  /// format's description.
  template <typename T>
  void vector(const std::string& name, int array_class, int data_type, const std::vector<T>& values) {
    array(name, array_class, data_type, static_cast<std::int32_t>(values.size()), 1, values);
  }

  template <typename T>
  void array(const std::string& name, int array_class, int data_type, std::int32_t rows, std::int32_t columns,
             const std::vector<T>& values) {
    const std::string outer = std::exchange(bytes_, "");
    put<std::uint32_t>(6), put<std::uint32_t>(8), put<std::uint32_t>(static_cast<std::uint32_t>(array_class)),
        put<std::uint32_t>(0);
    put<std::uint32_t>(5), put<std::uint32_t>(8), put<std::int32_t>(rows), put<std::int32_t>(columns);
    put<std::uint32_t>(1), put<std::uint32_t>(static_cast<std::uint32_t>(name.size()));
    bytes_ += name;
    pad();
    put<std::uint32_t>(static_cast<std::uint32_t>(data_type)),
        put<std::uint32_t>(static_cast<std::uint32_t>(values.size() * sizeof(T)));
    for (const T value : values) put<T>(value);
    pad();
    const std::string inner = std::exchange(bytes_, outer);
    put<std::uint32_t>(14), put<std::uint32_t>(static_cast<std::uint32_t>(inner.size()));
    bytes_ += inner;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  template <typename T>
  void put(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    const bool swap = big_endian_ == (std::endian::native == std::endian::little);
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes_ += raw[swap ? sizeof(T) - 1 - i : i];
  }
  void pad() { bytes_.resize((bytes_.size() + 7) / 8 * 8, '\0'); }

  bool big_endian_;
  std::string bytes_;
};

}  // namespace lacuna::test
