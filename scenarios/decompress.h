// Compressed blocks of a bag, with an end to what they may become.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lacuna {

/// What `bytes` (one or more whole frames) become: exactly `size` bytes, or up to `most` where `size` is npos. Memory
/// grows with what really comes out. Throws MessageFault.
std::string unpack_zstd(std::string_view bytes, std::size_t size, std::size_t most);
std::string unpack_lz4(std::string_view bytes, std::size_t size, std::size_t most);

}  // namespace lacuna
