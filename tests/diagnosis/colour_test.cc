// Coloured residuals: fitted, whitened, and how long they remember.
#include "diagnosis/colour.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/noise.h"

namespace lacuna {
namespace {

using namespace test;

constexpr Eigen::Index kSamples = 20000;
constexpr double kMemory = 0.9;              // of the autoregressive process: x = kMemory last + noise
constexpr double kFourErrors = 4.0 / 141.0;  // four standard errors of an autocorrelation of 20,000 white samples

/// First-order autoregressive, innovations of rms 1, stationary from the first sample.
Eigen::VectorXd autoregressive(Eigen::Index n, double a, std::uint64_t seed) {
  Eigen::VectorXd x = white(n, seed);
  x(0) /= std::sqrt(1.0 - a * a);
  for (Eigen::Index k = 1; k < n; ++k) x(k) += a * x(k - 1);
  return x;
}

double autocorrelation(const Eigen::VectorXd& x, Eigen::Index lag) {
  return x.head(x.size() - lag).dot(x.tail(x.size() - lag)) / x.squaredNorm();
}

const std::vector<ResidualBlock> kOne{{0, 0, 0, kSamples}};
const std::vector<double> kUnknown{std::nan("")};

TEST(Colour, InnovationsOfAnAutoregressiveProcessAreWhiteAndOfUnitSize) {
  const Eigen::VectorXd x = 3.0 * autoregressive(kSamples, kMemory, 1);
  const Colour colour(x, kOne, kUnknown);
  Eigen::VectorXd white = x;
  colour.whiten(white, kOne);
  EXPECT_GT(autocorrelation(x, 1), 0.85);
  EXPECT_NEAR(white.squaredNorm() / static_cast<double>(kSamples), 1.0, 0.01);  // its own sample variance
  for (const Eigen::Index lag : {1, 2, 3, 5, 10}) EXPECT_NEAR(autocorrelation(white, lag), 0.0, kFourErrors) << lag;
}

TEST(Colour, WhitensEveryColumnAsTheResidual) {
  const Eigen::VectorXd x = autoregressive(kSamples, kMemory, 2);
  const Colour colour(x, kOne, kUnknown);
  Eigen::MatrixXd both(kSamples, 2);
  both << x, 2.0 * x;
  Eigen::VectorXd alone = x;
  colour.whiten(both, kOne);
  colour.whiten(alone, kOne);
  EXPECT_EQ((both.col(0) - alone).norm(), 0.0);
  EXPECT_LT((both.col(1) - 2.0 * alone).norm(), 1e-9 * alone.norm());
}

TEST(Colour, DoesNotCarryOverFromOneBlockToTheNext) {
  // A process that is cut: the second block's first innovation is its own value over the process's rms.
  Eigen::VectorXd x = autoregressive(kSamples, kMemory, 3);
  const std::vector<ResidualBlock> cut{{0, 0, 0, kSamples / 2}, {1, 0, kSamples / 2, kSamples / 2}};
  x.tail(kSamples / 2) = autoregressive(kSamples / 2, kMemory, 4);
  const Colour colour(x, cut, kUnknown);
  Eigen::VectorXd white = x, moved = x;
  moved(kSamples / 2 - 1) += 100.0;
  colour.whiten(white, cut);
  colour.whiten(moved, cut);
  EXPECT_EQ((moved - white).tail(kSamples / 2).norm(), 0.0);
  EXPECT_NEAR(white(kSamples / 2) / x(kSamples / 2), std::sqrt(1.0 - kMemory * kMemory), 0.05);
}

TEST(Colour, OfWhiteNoiseHasNoOrder) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Eigen::VectorXd x = 0.2 * white(kSamples, seed);
    const Colour colour(x, kOne, kUnknown);
    Eigen::VectorXd scaled = x;
    colour.whiten(scaled, kOne);
    // Order 0: every row divided by one number, the rms.
    EXPECT_LT((scaled - x / std::sqrt(x.squaredNorm() / kSamples)).norm(), 1e-9 * scaled.norm()) << seed;
    EXPECT_EQ(colour.correlation_samples(0), 1.0) << seed;
  }
}

TEST(Colour, RemembersAsLongAsTheProcessDoes) {
  const Colour colour(autoregressive(kSamples, kMemory, 6), kOne, kUnknown);
  // Sum over all lags of a^|k| = (1 + a)/(1 - a) = 19; 20,000 samples hold a thousand such memories: 10 % three times
  // their error.
  EXPECT_NEAR(colour.correlation_samples(0), (1.0 + kMemory) / (1.0 - kMemory), 2.0);
}

TEST(Colour, NoInnovationLiesUnderTheSensorsNoise) {
  const std::vector<double> floor{2.0};
  Eigen::VectorXd x = white(kSamples, 7);
  const Colour colour(x, kOne, floor);
  colour.whiten(x, kOne);
  EXPECT_NEAR(std::sqrt(x.squaredNorm() / kSamples), 0.5, 0.01);
}

TEST(Colour, IsEachChannelsOwn) {
  Eigen::VectorXd x(2 * kSamples);
  x << white(kSamples, 8), autoregressive(kSamples, kMemory, 9);
  const std::vector<ResidualBlock> blocks{{0, 0, 0, kSamples}, {0, 1, kSamples, kSamples}};
  const std::vector<double> unknown{std::nan(""), 0.0};
  const Colour colour(x, blocks, unknown);
  EXPECT_EQ(colour.correlation_samples(0), 1.0);
  EXPECT_GT(colour.correlation_samples(1), 10.0);
}

}  // namespace
}  // namespace lacuna
