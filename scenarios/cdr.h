// Numbers and texts out of a message in CDR, the encoding of ROS 2 (OMG DDS-XTypes, plain CDR version 1).
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace lacuna {

/// What is wrong with a message; whoever knows its file and topic makes an InputError of it.
struct MessageFault : std::runtime_error {
  MessageFault(std::string what_found, std::string what_expected)
      : std::runtime_error(what_found), found(std::move(what_found)), expected(std::move(what_expected)) {}
  std::string found, expected;
};

/// Walks one message. Every read throws MessageFault rather than pass its end; nothing is copied or allocated, and the
/// texts that come out are views of the message.
class CdrReader {
 public:
  /// `message` begins with the four bytes of its encapsulation: 0x0000 (big endian) or 0x0001 (little endian), two
  /// options. Parameter lists and version 2 are refused by their number.
  explicit CdrReader(std::string_view message);

  std::int32_t int32() { return static_cast<std::int32_t>(uint32()); }
  std::uint32_t uint32() { return static_cast<std::uint32_t>(whole(4)); }
  float float32();
  double float64();
  /// Without its closing NUL; an empty one may be written with or without it.
  std::string_view text();
  /// How many elements a sequence has; refused where the rest of the message cannot hold that many of `least` bytes.
  std::size_t count(std::size_t least);

 private:
  /// The next `bytes` bytes (4 or 8), aligned to their size counted from the end of the encapsulation.
  std::uint64_t whole(std::size_t bytes);

  std::string_view body_;
  std::size_t at_ = 0;
  bool big_endian_ = false;
};

}  // namespace lacuna
