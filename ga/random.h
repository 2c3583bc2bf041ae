// Counter-based random numbers: every draw is a pure function of (seed, generation, individual, number of the draw), so
// a result depends neither on the number of threads nor on the order in which individuals are worked on.
//
// The generator is Philox4x32-10 of the Random123 library: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw,
// "Parallel random numbers: as easy as 1, 2, 3", SC'11, doi:10.1145/2063384.2063405.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace lacuna {

/// One block of Philox4x32-10: ten rounds of a keyed bijection on 128 bits.
std::array<std::uint32_t, 4> philox_block(const std::array<std::uint32_t, 4>& counter,
                                          const std::array<std::uint32_t, 2>& key);

/// The stream of draws that belongs to one individual of one generation. Two streams of different (seed, generation,
/// individual, purpose) never share a block. Cheap to make: it holds a counter and four words.
class RandomStream {
 public:
  /// `purpose` separates uses that would otherwise meet at the same individual.
  RandomStream(std::uint64_t seed, std::uint32_t generation, std::uint32_t individual, std::uint32_t purpose = 0)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        counter_{0, purpose, individual, generation} {}

  /// 32 random bits.
  std::uint32_t bits32() {
    if (next_ == block_.size()) {
      block_ = philox_block(counter_, key_);
      ++counter_[0];
      next_ = 0;
    }
    return block_[next_++];
  }

  /// 64 random bits.
  std::uint64_t bits64() {
    const std::uint64_t high = bits32();
    return high << 32 | bits32();
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(bits64() >> 11) * 0x1p-53; }

  /// Uniform in [lower, upper).
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

  /// True with probability `p`: never for p <= 0, always for p >= 1.
  bool chance(double p) { return uniform() < p; }

  /// Uniform in 0 .. count-1 without bias (draws that would favour small numbers are rejected); `count` at least 1.
  std::uint64_t below(std::uint64_t count) {
    const std::uint64_t reject_under = (0 - count) % count;  // 2^64 mod count
    std::uint64_t draw = bits64();
    while (draw < reject_under) draw = bits64();
    return draw % count;
  }

  /// Normal with mean 0 and standard deviation 1 (Box and Muller; the second value is dropped, which keeps a stream's
  /// state its counter alone).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  std::size_t next_ = 4;  // words of the block already used
};

}  // namespace lacuna
