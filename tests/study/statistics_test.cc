#include "study/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lacuna {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Quartiles, LieBetweenOrderStatistics) {
  const Quartiles q = quartiles_of(std::vector<double>{4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(q.low, 1.75);
  EXPECT_DOUBLE_EQ(q.median, 2.5);
  EXPECT_DOUBLE_EQ(q.high, 3.25);
  EXPECT_EQ(quartiles_of(std::vector<double>{7.0}).low, 7.0);
}

TEST(Quartiles, LeaveNanOutAndKeepInfinityLast) {
  const Quartiles q = quartiles_of(std::vector<double>{kInfinity, std::nan(""), 1.0, 2.0, kInfinity, 3.0});
  EXPECT_EQ(q.median, 3.0);
  EXPECT_EQ(q.high, kInfinity);
  EXPECT_TRUE(std::isnan(quartiles_of({}).median));
}

TEST(RankSum, IsExactForSmallSamples) {
  // Of the 252 ways to divide ten values, two are as extreme as complete separation.
  const std::vector<double> low{1, 2, 3, 4, 5}, high{6, 7, 8, 9, 10};
  EXPECT_NEAR(rank_sum_p(low, high), 2.0 / 252.0, 1e-12);
  EXPECT_NEAR(rank_sum_p(high, low), 2.0 / 252.0, 1e-12);
  // One exchange more: rank sum 16 or less has 2 of 252 ways, twice that for two sides.
  EXPECT_NEAR(rank_sum_p(std::vector<double>{1, 2, 3, 4, 6}, std::vector<double>{5, 7, 8, 9, 10}), 4.0 / 252.0, 1e-12);
}

TEST(RankSum, TiesAndEqualSamplesTellNothing) {
  const std::vector<double> same{1.0, 1.0, 1.0};
  EXPECT_EQ(rank_sum_p(same, same), 1.0);
  EXPECT_EQ(rank_sum_p(same, {}), 1.0);
  // Mid-ranks: {1, 2} against {2, 3}; 1 + 2.5 of ten: below it only the 1 and a 2, in two of six ways.
  EXPECT_NEAR(rank_sum_p(std::vector<double>{1, 2}, std::vector<double>{2, 3}), 2.0 * 2.0 / 6.0, 1e-12);
}

TEST(RankSum, OrdersInfinitiesAsLargest) {
  EXPECT_NEAR(rank_sum_p(std::vector<double>{1, 2, 3, 4}, std::vector<double>{5, 6, kInfinity, kInfinity}), 2.0 / 70.0,
              1e-12);
}

}  // namespace
}  // namespace lacuna
