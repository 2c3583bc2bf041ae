// Standard errors under what real rests look like: slow, and larger in some motions than in others.
#include "ga/sandwich.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <set>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using test::Noise;

constexpr Eigen::Index kRows = 4000;

/// A slope that is asked for now and then, beside a constant.
Eigen::MatrixXd regressors() {
  Eigen::MatrixXd out(kRows, 2);
  for (Eigen::Index k = 0; k < kRows; ++k) out.row(k) << 1.0, std::sin(0.05 * static_cast<double>(k));
  return out;
}

/// First-order noise of unit size, three times as large where the second regressor is.
Eigen::VectorXd rest(const Eigen::MatrixXd& J, double memory, bool uneven, std::uint64_t seed) {
  Noise random(seed);
  Eigen::VectorXd out(kRows);
  double x = 0.0;
  for (Eigen::Index k = -500; k < kRows; ++k) {
    x = memory * x + std::sqrt(1.0 - memory * memory) * random();
    if (k >= 0) out(k) = x * (uneven ? 0.5 + 2.5 * std::fabs(J(k, 1)) : 1.0);
  }
  return out;
}

struct Errors {
  Eigen::Vector2d scatter = Eigen::Vector2d::Zero();   ///< of the estimates, over draws
  Eigen::Vector2d sandwich = Eigen::Vector2d::Zero();  ///< mean
  Eigen::Vector2d white = Eigen::Vector2d::Zero();     ///< mean
};

Errors errors_of(double memory, bool uneven) {
  constexpr int kDraws = 200;
  const Eigen::MatrixXd J = regressors();
  const Eigen::MatrixXd inverse = (J.transpose() * J).inverse();
  const std::vector<ResidualBlock> layout{{0, 0, 0, kRows}};
  const std::vector<int> blocks = time_blocks(layout, (1.0 + memory) / (1.0 - memory));
  Errors out;
  for (int d = 0; d < kDraws; ++d) {
    const Eigen::VectorXd y = rest(J, memory, uneven, static_cast<std::uint64_t>(d) + 1);
    const Eigen::Vector2d estimate = inverse * (J.transpose() * y);
    const Eigen::VectorXd r = y - J * estimate;
    const double variance = r.squaredNorm() / static_cast<double>(kRows - 2);
    out.scatter += estimate.cwiseAbs2() / kDraws;
    out.sandwich += sandwich_errors(inverse, J, r, blocks) / kDraws;
    out.white += (variance * inverse).diagonal().cwiseSqrt() / kDraws;
  }
  out.scatter = out.scatter.cwiseSqrt();
  return out;
}

TEST(Sandwich, IsTheWhiteErrorWhereTheRestIsWhite) {
  const Errors e = errors_of(0.0, false);
  for (int a = 0; a < 2; ++a) {
    EXPECT_NEAR(e.sandwich(a), e.white(a), 0.1 * e.white(a));
    EXPECT_NEAR(e.sandwich(a), e.scatter(a), 0.15 * e.scatter(a));
  }
}

TEST(Sandwich, HoldsForASlowAndUnevenRestWhereTheWhiteErrorDoesNot) {
  const Errors e = errors_of(0.95, true);
  for (int a = 0; a < 2; ++a) {
    EXPECT_NEAR(e.sandwich(a), e.scatter(a), 0.2 * e.scatter(a));
    EXPECT_LT(e.white(a), 0.4 * e.scatter(a));
  }
}

TEST(Sandwich, SaysNothingFromASingleBlock) {
  const Eigen::MatrixXd J = regressors(), C = Eigen::MatrixXd::Identity(2, 2);
  const std::vector<int> one(kRows, 0);
  EXPECT_EQ(sandwich_errors(C, J, rest(J, 0.5, false, 1), one).norm(), 0.0);
}

TEST(TimeBlocks, HoldAllChannelsOfAStretchAndSpanWindows) {
  const std::vector<ResidualBlock> layout{{0, 0, 0, 100}, {0, 1, 100, 100}, {1, 0, 200, 100}, {1, 1, 300, 100}};
  const std::vector<int> blocks = time_blocks(layout, 1.0);
  ASSERT_EQ(blocks.size(), 400u);
  EXPECT_EQ(std::set<int>(blocks.begin(), blocks.end()).size(), 40u);
  for (std::size_t k = 0; k < 100; ++k) {
    EXPECT_EQ(blocks[k], blocks[100 + k]) << "both channels at one time";
    EXPECT_EQ(blocks[k] + 20, blocks[200 + k]) << "the second window follows the first";
  }
  const std::vector<int> slow = time_blocks(layout, 1000.0);
  EXPECT_EQ(std::set<int>(slow.begin(), slow.end()).size(), 10u) << "never fewer";
}

}  // namespace
}  // namespace lacuna
