#include "ga/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace lacuna {
namespace {

using Block = std::array<std::uint32_t, 4>;

// The known answers that the authors of the generator publish with it (Random123, kat_vectors, philox4x32 10).
TEST(Philox, GivesThePublishedKnownAnswers) {
  EXPECT_EQ(philox_block({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const std::uint32_t ones = 0xffffffff;
  EXPECT_EQ(philox_block({ones, ones, ones, ones}, {ones, ones}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox_block({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, RepeatsForTheSameKeyAndDiffersInEveryPartOfIt) {
  const auto first = [](RandomStream stream) { return stream.bits64(); };
  EXPECT_EQ(first({1, 2, 3}), first({1, 2, 3}));
  const std::set<std::uint64_t> draws = {first({1, 2, 3}),   first({2, 2, 3}), first({1ull << 32, 2, 3}),
                                         first({1, 3, 3}),   first({1, 2, 4}), first({1, 3, 2}),
                                         first({1, 2, 3, 1})};
  EXPECT_EQ(draws.size(), 7u);
}

TEST(RandomStream, UniformStaysInItsIntervalWithTheRightMoments) {
  RandomStream stream(7, 0, 0);
  const int n = 100000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = stream.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    squares += x * x;
  }
  // Five standard errors: sqrt(1/12/n) and sqrt(4/45/n).
  EXPECT_NEAR(sum / n, 0.5, 5 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(squares / n, 1.0 / 3.0, 5 * std::sqrt(4.0 / 45 / n));
}

TEST(RandomStream, BelowGivesEveryNumberEquallyOften) {
  RandomStream stream(11, 0, 0);
  const int n = 70000, count = 7;
  std::vector<int> seen(count);
  for (int i = 0; i < n; ++i) ++seen[stream.below(count)];
  const double expected = n / 7.0, deviation = std::sqrt(expected * 6 / 7);
  for (const int times : seen) EXPECT_NEAR(times, expected, 5 * deviation);
}

TEST(RandomStream, BelowOneIsZeroAndHugeCountsAreReached) {
  RandomStream stream(3, 0, 0);
  EXPECT_EQ(stream.below(1), 0u);
  const std::uint64_t count = (1ull << 63) + 1;  // the worst case for rejection: almost half of all draws
  bool upper_half = false;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t draw = stream.below(count);
    ASSERT_LT(draw, count);
    upper_half = upper_half || draw > count / 2;
  }
  EXPECT_TRUE(upper_half);
}

TEST(RandomStream, NormalHasTheMomentsOfTheNormalDistribution) {
  RandomStream stream(5, 0, 0);
  const int n = 100000;
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = stream.normal();
    ASSERT_TRUE(std::isfinite(x));
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 5 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1.0, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourth / n, 3.0, 5 * std::sqrt(96.0 / n));
}

TEST(RandomStream, ChanceNeverHappensAtZeroAndAlwaysAtOne) {
  RandomStream stream(9, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(stream.chance(0.0));
    EXPECT_TRUE(stream.chance(1.0));
  }
}

}  // namespace
}  // namespace lacuna
