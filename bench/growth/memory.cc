#include "bench/growth/memory.h"

#include <malloc.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> in_use{0}, peak{0};

void* counted(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  // aligned_alloc wants whole multiples.
  void* block = std::aligned_alloc(alignment, (size / alignment + 1) * alignment);
  if (block == nullptr) throw std::bad_alloc();
  const std::size_t now = in_use += ::malloc_usable_size(block);
  std::size_t most = peak;
  while (most < now && !peak.compare_exchange_weak(most, now)) {
  }
  return block;
}

void returned(void* block) noexcept {
  if (block == nullptr) return;
  in_use -= ::malloc_usable_size(block);
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, std::align_val_t to) { return counted(size, static_cast<std::size_t>(to)); }
void* operator new[](std::size_t size, std::align_val_t to) { return counted(size, static_cast<std::size_t>(to)); }
// What returns null instead of throwing (std::stable_sort asks so) must come from here as well: it is given back here.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return counted(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](std::size_t size, const std::nothrow_t& none) noexcept { return operator new(size, none); }
void operator delete(void* block) noexcept { returned(block); }
void operator delete[](void* block) noexcept { returned(block); }
void operator delete(void* block, std::size_t) noexcept { returned(block); }
void operator delete[](void* block, std::size_t) noexcept { returned(block); }
void operator delete(void* block, std::align_val_t) noexcept { returned(block); }
void operator delete[](void* block, std::align_val_t) noexcept { returned(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { returned(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { returned(block); }

namespace lacuna::bench {

std::size_t bytes_in_use() { return in_use; }
std::size_t peak_bytes() { return peak; }
void reset_peak() { peak = in_use.load(); }

}  // namespace lacuna::bench
