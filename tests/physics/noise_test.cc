// The noise of a reading, from the reading alone.
#include "physics/noise.h"

#include <gtest/gtest.h>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kPeriod = 0.01;  // s

constexpr double kAngleTravel = 0.05;  // rad

/// A motion that rests but from 4 to 5 s of 20 s, read with white noise and then rounded to `step` (0: not).
std::vector<double> mostly_still(const std::vector<double>& time, double noise, double step, double offset = 1.2345) {
  Noise random(7);
  std::vector<double> out;
  for (const double t : time) {
    const double moved = t < 4.0 ? 0.0 : t > 5.0 ? 1.0 : 0.5 - 0.5 * std::cos(std::numbers::pi * (t - 4.0));
    const double q = offset + kAngleTravel * moved + noise * random();
    out.push_back(step > 0.0 ? step * std::round(q / step) : q);
  }
  return out;
}

TEST(NoiseOf, AQuantisedReadingIsNoLessThanItsStepAllows) {
  const std::vector<double> time = clock(20.0, kPeriod);
  for (const double step : {1e-2, 1.5e-3}) {
    const double noise = noise_of(time, mostly_still(time, 0.0, step));
    EXPECT_GE(noise, 0.99 * step / std::sqrt(12.0)) << step;
    EXPECT_LE(noise, step) << step;
  }
}

TEST(NoiseOf, WhiteNoiseIsWhatItIsWhetherTheReadingMovesOrNot) {
  const std::vector<double> time = clock(20.0, kPeriod);
  for (const double step : {0.0, 1e-5, 1e-3})
    EXPECT_NEAR(noise_of(time, mostly_still(time, 1e-3, step)), 1e-3, 1.2e-4) << step;
}

TEST(NoiseOf, AReadingThatHoldsItsLastValueSaysNothingWhileItDoes) {
  const std::vector<double> time = clock(20.0, kPeriod);
  std::vector<double> held = mostly_still(time, 1e-3, 0.0);
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (time[k] < 3.9 || time[k] > 7.0) held[k] = held[390];
  }
  EXPECT_NEAR(noise_of(time, held), 1e-3, 3e-4);
}

TEST(NoiseOf, MissingSamplesAreLeftOut) {
  const std::vector<double> time = clock(20.0, kPeriod);
  std::vector<double> signal = mostly_still(time, 1e-3, 0.0);
  for (std::size_t k = 0; k < signal.size(); k += 100) signal[k] = kMissing;
  EXPECT_NEAR(noise_of(time, signal), 1e-3, 1.5e-4);
  EXPECT_TRUE(std::isnan(noise_of(time, std::vector<double>(time.size(), kMissing))));
}

TEST(QuantisationStep, IsTheSpacingOfTheLevelsWhateverScaleAndOffset) {
  const std::vector<double> time = clock(20.0, kPeriod);
  for (const double step : {1e-2, 1.53398e-3, 1e-5})
    EXPECT_NEAR(quantisation_step(mostly_still(time, 3.0 * step, step)), step, 1e-6 * step) << step;
  // Counts of an encoder as a logger prints them, four decimals.
  std::vector<double> printed = mostly_still(time, 0.0, 1.53398e-3);
  for (double& q : printed) q = std::round(1e4 * q) / 1e4;
  EXPECT_NEAR(quantisation_step(printed), 1.53398e-3, 2e-5);
  EXPECT_NEAR(quantisation_step({0.5, 0.5, 0.5, 0.5, 0.75, 0.5, 0.5, 0.75}), 0.25, 1e-12);
}

TEST(QuantisationStep, IsNoneWhereValuesHaveNoCommonSpacing) {
  const std::vector<double> time = clock(20.0, kPeriod);
  EXPECT_EQ(quantisation_step(mostly_still(time, 1e-3, 0.0)), 0.0);
  EXPECT_EQ(quantisation_step(mostly_still(time, 0.0, 0.0)), 0.0) << "rests, then moves smoothly";
  EXPECT_EQ(quantisation_step({}), 0.0);
  EXPECT_EQ(quantisation_step({1.0, 1.0, kMissing}), 0.0);
}

}  // namespace
}  // namespace lacuna
