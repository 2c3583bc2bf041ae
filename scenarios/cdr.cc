#include "scenarios/cdr.h"

#include <fmt/format.h>

#include <bit>

namespace lacuna {
namespace {

constexpr std::size_t kEncapsulationBytes = 4;

}  // namespace

CdrReader::CdrReader(std::string_view message) {
  if (message.size() < kEncapsulationBytes)
    throw MessageFault(fmt::format("{} bytes", message.size()), "a message in CDR, with four bytes of encapsulation");
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(message[i]); };
  const unsigned form = unsigned{byte(0)} << 8 | byte(1);
  if (form > 1)
    throw MessageFault(fmt::format("the encapsulation 0x{:04x}", form), "plain CDR, 0x0000 or 0x0001 (XCDR version 1)");
  big_endian_ = form == 0;
  body_ = message.substr(kEncapsulationBytes);
}

std::uint64_t CdrReader::whole(std::size_t bytes) {
  const std::size_t start = (at_ + bytes - 1) / bytes * bytes;
  if (start > body_.size() || body_.size() - start < bytes)
    throw MessageFault(fmt::format("an end after {} bytes", kEncapsulationBytes + body_.size()),
                       fmt::format("a number of {} bytes at byte {}", bytes, kEncapsulationBytes + start));
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const auto byte = static_cast<unsigned char>(body_[start + (big_endian_ ? i : bytes - 1 - i)]);
    out = out << 8 | byte;
  }
  at_ = start + bytes;
  return out;
}

float CdrReader::float32() { return std::bit_cast<float>(uint32()); }
double CdrReader::float64() { return std::bit_cast<double>(whole(8)); }

std::string_view CdrReader::text() {
  const std::size_t length = uint32();
  if (length > body_.size() - at_)
    throw MessageFault(fmt::format("a text of {} bytes where {} are left", length, body_.size() - at_),
                       "a message that holds its texts");
  std::string_view out = body_.substr(at_, length);
  at_ += length;
  if (!out.empty()) {
    if (out.back() != '\0') throw MessageFault("a text without its closing NUL", "one");
    out.remove_suffix(1);
  }
  return out;
}

std::size_t CdrReader::count(std::size_t least) {
  const std::size_t elements = uint32();
  if (elements > (body_.size() - at_) / least)
    throw MessageFault(fmt::format("a sequence of {} elements where {} bytes are left", elements, body_.size() - at_),
                       "a message that holds its sequences");
  return elements;
}

}  // namespace lacuna
