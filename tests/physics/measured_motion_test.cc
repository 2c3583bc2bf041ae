// Measured motions: what the filter and the clock make of positions and speeds.
#include "physics/measured_motion.h"

#include <gtest/gtest.h>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kSpacing = 0.01;      // s, in the mean
constexpr double kSeconds = 12.0;      // of a recording
constexpr double kMotionCutoff = 8.0;  // Hz: more than ten times the fastest sine
constexpr double kEdge = 1.0;          // s at either end, where the filter feels that the recording ends

/// A sum of three sines and its derivatives.
struct Sines {
  double q = 0.0, v = 0.0, a = 0.0;
};
constexpr double kAmplitude[] = {0.6, 0.3, 0.1}, kHertz[] = {0.17, 0.41, 0.73};
Sines sines(double t) {
  Sines out;
  for (int k = 0; k < 3; ++k) {
    const double w = 2.0 * std::numbers::pi * kHertz[k], phase = w * t + k;
    out.q += kAmplitude[k] * std::sin(phase);
    out.v += kAmplitude[k] * w * std::cos(phase);
    out.a -= kAmplitude[k] * w * w * std::sin(phase);
  }
  return out;
}

/// The mean period of kSpacing, each sample up to 40 % of it off its place.
std::vector<double> uneven_clock() {
  Noise random(7);
  std::vector<double> time = clock(kSeconds, kSpacing);
  for (std::size_t i = 1; i + 1 < time.size(); ++i) time[i] += 0.8 * kSpacing * (random.uniform() - 0.5);
  return time;
}

RawMotion recorded(const std::vector<double>& time, bool speeds) {
  RawMotion raw{time, {{}}, {}, {}, {}};
  if (speeds) raw.velocity = {{}};
  for (const double t : time) {
    raw.position[0].push_back(sines(t).q);
    if (speeds) raw.velocity[0].push_back(sines(t).v);
  }
  return raw;
}

/// Largest errors against the closed form, away from the ends.
Sines worst(const MeasuredMotion& m) {
  Sines out;
  for (std::size_t k = 0; k < m.samples(); ++k) {
    if (m.time[k] < kEdge || m.time[k] > kSeconds - kEdge) continue;
    const Sines truth = sines(m.time[k]);
    out.q = std::max(out.q, std::fabs(m.q[0][k] - truth.q));
    out.v = std::max(out.v, std::fabs(m.v[0][k] - truth.v));
    out.a = std::max(out.a, std::fabs(m.a[0][k] - truth.a));
  }
  return out;
}

// rad, rad/s, rad/s^2 of amplitudes of 0.6, 1.9 and 6.6 or less. Central differences of a sine of .73 Hz at 100 Hz are
// short by (w h)^2/6 = 3.5e-4 of it; the passband by (.73/8)^8 = 5e-9.
constexpr double kPositionError = 1e-5, kSpeedError = 3e-4, kAccelerationError = 1.5e-3;
// On an uneven clock with it: what a cubic makes of an interval of up to 1.8 h, slopes from its neighbours, a (w h)^2
// hundredth of the bend; measured speeds go by straight lines, which miss (1.8 h)^2/8 of their own bend.
constexpr double kUnevenPosition = 5e-5, kUnevenSpeed = 1e-3, kUnevenAcceleration = 0.03;

TEST(MeasuredMotion, OfSumsOfSinesIsTheirClosedForm) {
  for (const bool speeds : {false, true}) {
    const Sines error = worst(measured_motion(recorded(clock(kSeconds, kSpacing), speeds), kMotionCutoff));
    EXPECT_LT(error.q, kPositionError) << speeds;
    EXPECT_LT(error.v, speeds ? kPositionError : kSpeedError) << speeds;
    EXPECT_LT(error.a, kAccelerationError) << speeds;
  }
}

TEST(MeasuredMotion, IsTheSameFromAnUnevenClock) {
  for (const bool speeds : {false, true}) {
    const MeasuredMotion m = measured_motion(recorded(uneven_clock(), speeds), kMotionCutoff);
    EXPECT_TRUE(is_even(m.time));
    EXPECT_NEAR(m.rate, 1.0 / kSpacing, 1e-9 / kSpacing);
    const Sines error = worst(m);
    EXPECT_LT(error.q, kUnevenPosition) << speeds;
    EXPECT_LT(error.v, kUnevenSpeed) << speeds;
    EXPECT_LT(error.a, kUnevenAcceleration) << speeds;
  }
}

TEST(MeasuredMotion, TakesMeasuredSpeedsForWhatTheyAre) {
  RawMotion raw = recorded(clock(kSeconds, kSpacing), true);
  constexpr double kTooFast = 1.2;
  for (double& v : raw.velocity[0]) v *= kTooFast;
  const MeasuredMotion m = measured_motion(raw, kMotionCutoff);
  for (std::size_t k = 200; k + 200 < m.samples(); ++k) {
    EXPECT_NEAR(m.v[0][k], kTooFast * sines(m.time[k]).v, kTooFast * kPositionError);
    EXPECT_NEAR(m.a[0][k], kTooFast * sines(m.time[k]).a, kTooFast * kAccelerationError);
    EXPECT_NEAR(m.q[0][k], sines(m.time[k]).q, kPositionError);
  }
}

TEST(MeasuredMotion, BridgesSamplesThatAreMissing) {
  for (const std::vector<double>& time : {clock(kSeconds, kSpacing), uneven_clock()}) {
    RawMotion raw = recorded(time, false);
    raw.position[0][500] = raw.position[0][501] = raw.position[0][700] = kMissing;
    const Sines error = worst(measured_motion(raw, kMotionCutoff));
    // A straight line across three periods leaves a (3 h)^2/8 = 1.3e-4 a; of that the filter keeps some.
    EXPECT_LT(error.q, 3e-4);
    EXPECT_LT(error.v, 0.02);
  }
}

TEST(MeasuredMotion, AJointWithoutMeasuredPositionStandsStillAtZero) {
  RawMotion raw = recorded(clock(kSeconds, kSpacing), false);
  raw.position.push_back({});
  const MeasuredMotion m = measured_motion(raw, kMotionCutoff);
  ASSERT_EQ(m.q.size(), 2u);
  for (const auto* signal : {&m.q[1], &m.v[1], &m.a[1], &m.direction[1]})
    EXPECT_TRUE(std::all_of(signal->begin(), signal->end(), [](double x) { return x == 0.0; }));
}

TEST(MeasuredMotion, DirectionIsHeldWhileTheJointRests) {
  // From 1 s to 3 s up, from 6 s to 8 s down, each starting and stopping smoothly; still in between.
  constexpr double kWay = 0.5, kNoise = 1e-4;  // rad
  RawMotion raw{clock(8.0, kSpacing), {{}}, {}, {kNoise}, {}};
  Noise random(3);
  const auto moved = [](double since) {
    const double share = std::clamp(since / 2.0, 0.0, 1.0);
    return kWay * (share - std::sin(2.0 * std::numbers::pi * share) / (2.0 * std::numbers::pi));
  };
  for (const double t : raw.time) raw.position[0].push_back(moved(t - 1.0) - moved(t - 6.0) + kNoise * random());
  const MeasuredMotion m = measured_motion(raw, kMotionCutoff);
  EXPECT_GT(m.v_error[0], 0.0);
  constexpr double kSlow = 0.2;  // s after a start, in which the speed is not above its noise yet
  std::size_t wrong = 0, looked = 0;
  for (std::size_t k = 0; k < m.samples(); ++k) {
    const double t = m.time[k];
    if (t > 1.0 + kSlow && t < 6.0) wrong += m.direction[0][k] != 1.0, ++looked;
    if (t > 6.0 + kSlow && t < 8.0) wrong += m.direction[0][k] != -1.0, ++looked;
  }
  // While it rests, noise passes three standard errors in one of 370 half cycles of the cutoff: here in none or one.
  EXPECT_LT(static_cast<double>(wrong), 0.05 * static_cast<double>(looked));
}

TEST(MeasuredMotion, DirectionIsNoneBeforeTheFirstMotionAndKeptAfterTheLast) {
  RawMotion raw{clock(4.0, kSpacing), {{}}, {{}}, {}, {1e-3}};
  for (const double t : raw.time) {
    const bool moves = t > 1.5 && t < 2.5;
    raw.velocity[0].push_back(moves ? 0.4 : 0.0);
    raw.position[0].push_back(0.4 * std::clamp(t - 1.5, 0.0, 1.0));
  }
  const MeasuredMotion m = measured_motion(raw, kMotionCutoff);
  EXPECT_EQ(m.direction[0].front(), 0.0);
  EXPECT_EQ(m.direction[0][100], 0.0);
  EXPECT_EQ(m.direction[0][200], 1.0);
}

TEST(MeasuredMotion, SaysHowMuchNoiseItsSpeedsKeep) {
  // White noise alone; its speeds' rms against what is said of it.
  constexpr double kNoise = 1e-3;
  for (const bool speeds : {false, true}) {
    RawMotion raw{clock(200.0, kSpacing), {{}}, {}, {kNoise}, {kNoise}};
    Noise random(11);
    for (std::size_t k = 0; k < raw.time.size(); ++k) raw.position[0].push_back(kNoise * random());
    if (speeds) raw.velocity = raw.position;
    const MeasuredMotion m = measured_motion(raw, kMotionCutoff);
    double squares = 0.0;
    for (const double v : m.v[0]) squares += v * v;
    const double rms = std::sqrt(squares / static_cast<double>(m.samples()));
    // 200 s hold some 3,200 independent half cycles of the cutoff: 1.3 % standard error; four of them.
    EXPECT_NEAR(m.v_error[0] / rms, 1.0, 0.05) << speeds;
  }
}

TEST(FilterGain, IsTheRmsThatWhiteNoiseKeeps) {
  const ZeroPhaseLowPass filter(kMotionCutoff, 1.0 / kSpacing);
  for (const int passes : {1, 2}) {
    const FilterGain gain = filter_gain(filter, passes);
    Noise random(5);
    std::vector<double> x(100000);
    for (double& each : x) each = random();
    for (int k = 0; k < passes; ++k) filter.apply(x);
    double value = 0.0, slope = 0.0;
    for (std::size_t k = 1; k + 1 < x.size(); ++k)
      value += x[k] * x[k], slope += 0.25 * (x[k + 1] - x[k - 1]) * (x[k + 1] - x[k - 1]);
    const double n = static_cast<double>(x.size() - 2);
    // 16,000 half cycles: 0.6 % standard error of an rms; four of them.
    EXPECT_NEAR(std::sqrt(value / n) / gain.value, 1.0, 0.024) << passes;
    EXPECT_NEAR(std::sqrt(slope / n) / gain.slope, 1.0, 0.024) << passes;
  }
}

TEST(Clock, IsEvenWithinOnePercentOfAPeriod) {
  std::vector<double> time = clock(1.0, kSpacing);
  EXPECT_TRUE(is_even(time));
  time[40] += 0.005 * kSpacing;
  EXPECT_TRUE(is_even(time));
  time[40] += 0.02 * kSpacing;
  EXPECT_FALSE(is_even(time));
  EXPECT_TRUE(is_even({0.0, 3.0}));
}

TEST(Clock, EvenTimesKeepTheSpanAndTheCount) {
  const std::vector<double> time = uneven_clock(), even = even_times(time);
  ASSERT_EQ(even.size(), time.size());
  EXPECT_DOUBLE_EQ(even.front(), time.front());
  EXPECT_NEAR(even.back(), time.back(), 1e-12 * time.back());
  EXPECT_TRUE(is_even(even));
}

TEST(Resampled, GoesByStraightLinesBridgesMissingSamplesAndHoldsTheEnds) {
  const std::vector<double> time{0.0, 1.0, 3.0, 4.0, 6.0}, signal{kMissing, 2.0, kMissing, 8.0, kMissing};
  const std::vector<double> out = resampled(time, signal, {0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  const std::vector<double> expected{2.0, 2.0, 4.0, 6.0, 8.0, 8.0};
  EXPECT_LT(worst_difference(out, expected), 1e-12);
  EXPECT_TRUE(same_bits(resampled({0.0, 1.0}, {kMissing, 5.0}, {0.0, 1.0}), {5.0, 5.0}));
  EXPECT_TRUE(same_bits(resampled({0.0, 1.0}, {kMissing, kMissing}, {0.0, 1.0}), {0.0, 0.0}));
}

TEST(Resampled, AtItsOwnTimesIsTheSignalToTheBit) {
  const std::vector<double> time = uneven_clock();
  std::vector<double> signal;
  for (const double t : time) signal.push_back(sines(t).q);
  EXPECT_TRUE(same_bits(resampled(time, signal, time), signal));
}

TEST(MeasuredMotion, RefusesACutoffThatTheClockCannotHold) {
  EXPECT_THROW(measured_motion(recorded(clock(kSeconds, kSpacing), false), 0.5 / kSpacing), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
