// What the whole program holds through operator new: this program's own operators count.
#pragma once

#include <cstddef>

namespace lacuna::bench {

std::size_t bytes_in_use();
/// Most that was in use since reset_peak().
std::size_t peak_bytes();
void reset_peak();

}  // namespace lacuna::bench
