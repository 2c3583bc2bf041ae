// Evidence against closed forms, and how often it errs where nothing is there.
#include "diagnosis/evidence.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>

#include "ga/least_squares.h"
#include "tests/diagnosis/noise.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

TEST(Autocorrelations, AreThoseOfAFirstOrderSeriesAndTellItFromWhiteNoise) {
  constexpr double kKept = 0.6;
  Eigen::VectorXd both(8000);
  both.head(4000) = white(4000, 1);
  const Eigen::VectorXd drive = white(4000, 2);
  double x = 0.0;
  for (Eigen::Index k = 0; k < 4000; ++k) both(4000 + k) = x = kKept * x + drive(k);
  const std::vector<ResidualBlock> blocks{{0, 0, 0, 4000}, {0, 1, 4000, 2000}, {1, 1, 6000, 2000}};
  const auto channels = autocorrelations(both, blocks);
  ASSERT_EQ(channels.size(), 2u);
  EXPECT_EQ(channels[1].samples, 4000.0);
  const double error = 1.0 / std::sqrt(4000.0);
  for (std::size_t lag = 1; lag <= 5; ++lag) {
    EXPECT_NEAR(channels[0].by_lag[lag - 1], 0.0, 4.0 * error);
    // Bartlett's standard error of a coloured series is at most sqrt((1 + phi^2) / (1 - phi^2)) = 1.46 times as large.
    EXPECT_NEAR(channels[1].by_lag[lag - 1], std::pow(kKept, static_cast<double>(lag)), 6.0 * error);
  }
  EXPECT_GT(channels[0].p_value, 1e-3);
  EXPECT_LT(channels[1].p_value, 1e-12);
}

TEST(Chance, IsTheTailOfChiSquareTimesTheTries) {
  for (const int parameters : {1, 2, 4}) {
    for (const double gain : {0.5, 3.0, 10.0}) {
      const boost::math::chi_squared law(parameters);
      const double tail = 1.0 - boost::math::cdf(law, 2.0 * gain);
      EXPECT_NEAR(chance(gain, parameters, 1), tail, 1e-9);
      EXPECT_NEAR(chance(gain, parameters, 7), std::min(1.0, 7.0 * tail), 1e-8);
    }
  }
  EXPECT_EQ(chance(0.0, 1, 10), 1.0);
  EXPECT_EQ(chance(-5.0, 1, 10), 1.0);
  EXPECT_LT(chance(1e6, 1, 10), 1e-300);
}

TEST(Gain, OfTheSameResidualIsNothing) {
  const Eigen::VectorXd r = white(1000, 1);
  const std::vector<ResidualBlock> blocks{{0, 0, 0, 500}, {0, 1, 500, 500}};
  EXPECT_EQ(residual_gain(r, r, blocks).log_likelihood, 0.0);
  EXPECT_EQ(heldout_gain(r, r, blocks).gain, 0.0);
  EXPECT_EQ(heldout_gain(r, r, blocks).share, 0.0);
}

TEST(Gain, OfWhiteNoiseHalvedIsThatOfItsLogarithm) {
  const Eigen::Index n = 4000;
  const Eigen::VectorXd r = white(n, 2), half = 0.5 * r;
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}};
  const Gain gain = residual_gain(r, half, blocks);
  // n_eff of white noise is n within its own error; n log 2 is what a Gaussian likelihood gains.
  EXPECT_NEAR(gain.log_likelihood, static_cast<double>(n) * std::log(2.0),
              0.15 * static_cast<double>(n) * std::log(2.0));
  EXPECT_NEAR(gain.share, 0.75, 1e-12);
}

/// What an effect might change: some seconds of a slow course, at 100 samples a second.
Eigen::VectorXd course(Eigen::Index n, Eigen::Index first, Eigen::Index count) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = first; k < first + count; ++k) out(k) = std::sin(0.02 * static_cast<double>(k - first));
  return out;
}

TEST(HeldoutGain, OfAChangeThatIsNotThereIsLuckInWhiteAndInSlowNoise) {
  constexpr Eigen::Index kCount = 4000;
  constexpr double kKept = 0.9;  // of slow noise, from sample to sample
  const std::vector<ResidualBlock> blocks{{0, 0, 0, kCount}};
  const Eigen::VectorXd change = 0.1 * course(kCount, 0, kCount);
  for (const bool slow : {false, true}) {
    int significant = 0;
    for (std::uint64_t k = 0; k < 100; ++k) {
      Eigen::VectorXd noise = white(kCount, k + 100);
      for (Eigen::Index i = 1; slow && i < kCount; ++i) noise(i) += kKept * noise(i - 1);
      significant += heldout_gain(noise, noise - change, blocks).p_value < 0.02;
    }
    EXPECT_LE(significant, 8) << slow;  // 2 expected; more than 7 have a chance of 1 in 1,000
  }
}

TEST(HeldoutGain, OfARealImprovementIsSignificant) {
  const Eigen::Index n = 2000;
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}};
  const Eigen::VectorXd after = white(n, 5);
  const HeldoutGain gain = heldout_gain(after + course(n, 0, n), after, blocks);
  EXPECT_LT(gain.p_value, 1e-4);
  EXPECT_GT(gain.gain, 2.0 * gain.error);
  EXPECT_NEAR(gain.share, 1.0 / 3.0, 0.05);  // .5 of 1.5
}

TEST(HeldoutGain, OfHalfASecondInTwentyIsSeen) {
  const Eigen::Index n = 2000;
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}};
  const Eigen::VectorXd after = white(n, 6), change = 1.5 * course(n, 900, 50);
  // 50 samples of mean square .3 * 2.25: 5.8 standard errors
  const HeldoutGain gain = heldout_gain(after + change, after, blocks);
  EXPECT_NEAR(gain.standard_errors, std::sqrt(change.squaredNorm()), 3.0);
  EXPECT_GT(gain.gain, 0.0);
}

TEST(HeldoutGain, OfTheRightChangeThriceTooLargeIsALoss) {
  const Eigen::Index n = 2000;
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}};
  const Eigen::VectorXd noise = white(n, 7), change = course(n, 0, n);
  const HeldoutGain gain = heldout_gain(noise + change, noise - 2.0 * change, blocks);
  EXPECT_LT(gain.gain, 0.0);
  EXPECT_GT(gain.standard_errors, 2.0);  // its direction is right
}

/// A linear model of two numbers, fitted to noise on one recording and predicting another: the second number moves the
/// first recording little and the other one much.
struct LinearFit {
  static constexpr Eigen::Index kSamples = 1000;
  explicit LinearFit(std::uint64_t seed) {
    fitted = elsewhere = Eigen::MatrixXd::Zero(kSamples, 2);
    fitted.col(0) = elsewhere.col(0) = course(kSamples, 0, kSamples);
    fitted.col(1) = course(kSamples, 400, 60);
    elsewhere.col(1) = course(kSamples, 0, kSamples).cwiseAbs();
    const Eigen::VectorXd noise = white(kSamples, 2 * seed), other = white(kSamples, 2 * seed + 1);
    const Eigen::VectorXd error = (fitted.transpose() * fitted).ldlt().solve(-fitted.transpose() * noise);
    residual = noise + fitted * error;
    heldout = other + elsewhere * error;
  }
  Eigen::MatrixXd fitted, elsewhere;
  Eigen::VectorXd residual, heldout;
  std::vector<ResidualBlock> blocks{{0, 0, 0, kSamples}};
};

TEST(PredictionSpread, IsTheFitsCovarianceSentThroughTheOtherJacobian) {
  const LinearFit fit(1);
  const Eigen::MatrixXd spread =
      prediction_spread(fit.fitted, fit.residual, fit.blocks, fit.elsewhere, Eigen::Vector2d::Zero());
  const double variance = fit.residual.squaredNorm() / effective_samples(fit.residual, fit.blocks);
  const Eigen::MatrixXd expected =
      variance * fit.elsewhere * (fit.fitted.transpose() * fit.fitted).inverse() * fit.elsewhere.transpose();
  EXPECT_LT((spread * spread.transpose() - expected).norm(), 1e-6 * expected.norm());
}

TEST(PredictionSpread, LeavesANumberWithoutEffectOut) {
  LinearFit fit(1);
  fit.fitted.col(1).setZero();
  const Eigen::MatrixXd spread =
      prediction_spread(fit.fitted, fit.residual, fit.blocks, fit.elsewhere, Eigen::Vector2d::Zero());
  EXPECT_TRUE(spread.allFinite());
  EXPECT_EQ(spread.rows(), LinearFit::kSamples);
}

TEST(HeldoutGain, OfAChangeThatFollowsTheFitsOwnErrorsIsLuckOnceTheyAreCounted) {
  int without = 0, with = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const LinearFit fit(k + 500);
    const Eigen::VectorXd after = fit.heldout - 0.05 * fit.elsewhere.col(1);  // settled beforehand, and wrong
    const Eigen::MatrixXd spread =
        prediction_spread(fit.fitted, fit.residual, fit.blocks, fit.elsewhere, Eigen::Vector2d::Zero());
    without += heldout_gain(fit.heldout, after, fit.blocks).p_value < 0.02;
    with += heldout_gain(fit.heldout, after, fit.blocks, spread).p_value < 0.02;
  }
  EXPECT_GT(without, 40) << "the errors of the fit pass for an effect";
  EXPECT_LE(with, 12);  // 4 expected; more than 12 have a chance of 1 in 4,000
}

TEST(Chance, OfTrainAndHeldOutTogetherIsFishers) {
  HeldoutGain heldout;
  for (const double p : {0.9, 0.03, 1e-6}) {
    heldout.p_value = p;
    for (const double gain : {0.5, 3.0, 10.0}) {
      const boost::math::chi_squared law(4);
      const double both = -2.0 * (std::log(chance(gain, 2, 1)) + std::log(p));
      const double tail = boost::math::cdf(boost::math::complement(law, both));
      EXPECT_NEAR(chance(gain, 2, heldout, 1) / tail, 1.0, 1e-9);
      EXPECT_NEAR(chance(gain, 2, heldout, 7), std::min(1.0, 7.0 * tail), 1e-9);
    }
  }
}

TEST(Stability, IsTheShareOfResamplesThatTheFirstWins) {
  const std::vector<double> better(30, 2.0), worse(30, 1.0);
  EXPECT_EQ(stability(better, worse, 1), 1.0);
  EXPECT_EQ(stability(worse, better, 1), 0.0);
  std::vector<double> a, b;
  for (int k = 0; k < 40; ++k) a.push_back(k % 2), b.push_back((k + 1) % 2);
  EXPECT_NEAR(stability(a, b, 3), 0.5, 0.15);  // ties count against; 400 resamples
  EXPECT_EQ(stability(a, b, 3), stability(a, b, 3));
  EXPECT_EQ(stability({}, {}, 1), 0.0);
}

TEST(ExcessOverNoise, FlagsTheChannelThatHasItAndNoOther) {
  const Eigen::Index n = 2000;
  Eigen::VectorXd r(2 * n);
  r.head(n) = white(n, 7);
  r.tail(n) = 1.5 * white(n, 8);
  const std::vector<ResidualBlock> blocks{{0, 0, 0, n}, {0, 1, n, n}};
  const std::vector<double> noise{1.0, 1.0};
  const auto found = excess_over_noise(r, blocks, noise);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].channel, 1);
  EXPECT_NEAR(found[0].ratio, 1.5, 0.1);
  const std::vector<double> unknown{kMissing, kMissing};
  EXPECT_TRUE(excess_over_noise(r, blocks, unknown).empty());
}

}  // namespace
}  // namespace lacuna
