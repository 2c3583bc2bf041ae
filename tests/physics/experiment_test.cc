// Cutting recordings into segments: where simulations start, how noise is estimated, what is refused.
#include "physics/experiment.h"

#include <gtest/gtest.h>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

/// A pendulum's recording with a given position signal; no velocity channel.
Scenario recorded(const std::vector<double>& time, const std::vector<double>& position,
                  Prediction prediction = FreeRun{}) {
  auto robot = bundled_robot("pendulum/pendulum.urdf");
  Scenario scenario = bare_scenario(robot, {}, false);
  Drive drive{time, {std::vector<double>(time.size(), 0.0)}};
  auto data = recording_of(*robot, drive, {{0.0}, {0.0}});
  data->columns[data->find("q_swing")] = position;
  add_recording(scenario, data);
  scenario.prediction = prediction;
  return scenario;
}

std::vector<double> parabola(const std::vector<double>& time) {
  std::vector<double> q;
  for (const double t : time) q.push_back(0.4 - 1.3 * t + 0.8 * t * t);
  return q;
}

/// Uneven spacing, 5 to 15 ms.
std::vector<double> irregular_clock(double seconds, std::uint64_t seed) {
  Noise random(seed);
  std::vector<double> time{0.0};
  while (time.back() < seconds) time.push_back(time.back() + 0.005 + 0.01 * random.uniform());
  return time;
}

TEST(LocalState, IsExactForAParabolaOnAnIrregularClockAlsoAtItsEnds) {
  const std::vector<double> time = irregular_clock(2.0, 1), q = parabola(time);
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, time.size() / 2, time.size() - 1}) {
    const LocalState s = local_state(time, q, at, 0, time.size(), 1e-9);
    EXPECT_NEAR(s.value, q[at], 1e-8) << "sample " << at;
    EXPECT_NEAR(s.slope, -1.3 + 1.6 * time[at], 1e-6) << "sample " << at;
  }
}

TEST(LocalState, SkipsMissingSamplesTheStartIncluded) {
  const std::vector<double> time = irregular_clock(2.0, 2);
  std::vector<double> q = parabola(time);
  q[50] = q[51] = q[53] = kMissing;
  const LocalState s = local_state(time, q, 50, 0, time.size(), 1e-9);
  EXPECT_NEAR(s.value, 0.4 - 1.3 * time[50] + 0.8 * time[50] * time[50], 1e-8);
  EXPECT_NEAR(s.slope, -1.3 + 1.6 * time[50], 1e-6);
}

TEST(LocalState, AveragesNoiseWhereTheMotionIsSmooth) {
  const double sigma = 1e-3;
  const std::vector<double> time = clock(4.0, 0.01);
  double squares = 0.0, slopes = 0.0;
  const int draws = 200;
  for (int k = 0; k < draws; ++k) {
    Noise random(static_cast<std::uint64_t>(k) + 1);
    std::vector<double> q = parabola(time);
    for (double& x : q) x += sigma * random();
    const LocalState s = local_state(time, q, 200, 0, time.size(), sigma);
    squares += std::pow(s.value - (0.4 - 1.3 * 2.0 + 0.8 * 4.0), 2);
    slopes += std::pow(s.slope - (-1.3 + 3.2), 2);
  }
  // A parabola through 161 samples: value 1.5 sigma / sqrt(n), slope sqrt(12) sigma / (T sqrt(n)); twice that allowed.
  EXPECT_LT(std::sqrt(squares / draws), 2.0 * 1.5 * sigma / std::sqrt(161.0));
  EXPECT_LT(std::sqrt(slopes / draws), 2.0 * std::sqrt(12.0) * sigma / 1.6 / std::sqrt(161.0));
}

TEST(LocalState, ErrorsHoldWhatAPolynomialLeavesOutOfASineAtAnyPhase) {
  const double sigma = 3e-4;
  const std::vector<double> time = clock(4.0, 0.01);
  const int draws = 400;
  for (const double hertz : {0.2, 0.7, 2.0, 4.0}) {
    const double rate = 2.0 * M_PI * hertz;
    double values = 0.0, slopes = 0.0;
    for (int k = 0; k < draws; ++k) {
      Noise random(static_cast<std::uint64_t>(k) + 1);
      const double phase = 2.0 * M_PI * random.uniform();
      std::vector<double> q;
      for (const double t : time) q.push_back(0.3 * std::sin(rate * t + phase) + sigma * random());
      const LocalState s = local_state(time, q, 200, 0, time.size(), sigma);
      values += std::pow((s.value - 0.3 * std::sin(rate * time[200] + phase)) / s.value_error, 2);
      slopes += std::pow((s.slope - 0.3 * rate * std::cos(rate * time[200] + phase)) / s.slope_error, 2);
    }
    // What a sine does within the samples used is known only from these: a slope's error may be half of what it should.
    EXPECT_LT(std::sqrt(values / draws), 1.25) << hertz << " Hz";
    EXPECT_LT(std::sqrt(slopes / draws), 2.0) << hertz << " Hz";
  }
}

TEST(LocalState, DoesNotReachAcrossAKink) {
  // A block that stops dead: far more samples lie beyond the kink than the slope may be taken from.
  const std::vector<double> time = clock(2.0, 0.01);
  std::vector<double> q;
  for (const double t : time) q.push_back(t < 1.0 ? t : 1.0);
  EXPECT_NEAR(local_state(time, q, 80, 0, time.size(), 1e-6).slope, 1.0, 1e-4);
  EXPECT_NEAR(local_state(time, q, 120, 0, time.size(), 1e-6).slope, 0.0, 1e-4);
}

TEST(NoiseEstimate, RecoversKnownWhiteNoiseWithinTenPercentUnderMotion) {
  for (const double sigma : {1e-4, 1e-3, 1e-2}) {
    for (const bool regular : {true, false}) {
      const std::vector<double> time = regular ? clock(20.0, 0.01) : irregular_clock(20.0, 4);
      Noise random(5);
      std::vector<double> q;
      for (const double t : time) q.push_back(0.3 * std::sin(2.0 * t) + 0.1 * t * t + sigma * random());
      EXPECT_NEAR(noise_from_differences(time, q), sigma, 0.1 * sigma) << (regular ? "regular" : "irregular");
    }
  }
}

TEST(NoiseEstimate, OfANoiseFreeParabolaIsTheFloorOfAMillionthOfItsRange) {
  const std::vector<double> time = irregular_clock(5.0, 6), q = parabola(time);
  const auto [low, high] = std::minmax_element(q.begin(), q.end());
  EXPECT_NEAR(noise_from_differences(time, q), 1e-6 * (*high - *low), 1e-12);
}

TEST(NoiseEstimate, IgnoresMissingSamplesAndSaysNothingOfAConstant) {
  const std::vector<double> time = clock(20.0, 0.01);
  Noise random(7);
  std::vector<double> q;
  for (std::size_t k = 0; k < time.size(); ++k)
    q.push_back(k % 50 == 0 ? kMissing : std::sin(time[k]) + 1e-3 * random());
  EXPECT_NEAR(noise_from_differences(time, q), 1e-3, 1.5e-4);  // fewer whole stretches
  EXPECT_FALSE(noise_from_differences(time, std::vector<double>(time.size(), 0.7)) > 1e-12);
}

TEST(Experiment, WindowsCoverTheRecordingAndStartFromTheMeasuredState) {
  const std::vector<double> time = irregular_clock(5.0, 8);
  std::vector<double> q;
  for (const double t : time) q.push_back(0.5 * std::sin(1.7 * t));
  const Experiment experiment = make_experiment(recorded(time, q, Windows{0.5}));
  ASSERT_GE(experiment.segments.size(), 9u);
  for (std::size_t s = 0; s < experiment.segments.size(); ++s) {
    const Segment& w = experiment.segments[s];
    const double begin = w.time(0), end = w.time(w.count - 1);
    EXPECT_LE(end - begin, 0.5 + 1e-9);
    EXPECT_GE(end - begin, 0.45);
    EXPECT_NEAR(w.q0[0], 0.5 * std::sin(1.7 * begin), 1e-4);
    EXPECT_NEAR(w.v0[0], 0.85 * std::cos(1.7 * begin), 2e-2);
    if (s > 0) {
      EXPECT_EQ(w.first, experiment.segments[s - 1].first + experiment.segments[s - 1].count - 1)
          << "no sample is lost";
    }
    EXPECT_EQ(w.measured[0].size(), w.count);
    EXPECT_EQ(w.measured[0][0], q[w.first]);
  }
}

TEST(Experiment, KeepsTheRecordingsOwnTimeRangeAndStartsItsClockAtZero) {
  const std::vector<double> time = clock(5.0, 0.01);
  Scenario scenario = recorded(time, parabola(time));
  scenario.recordings[0].from = 1.0;
  scenario.recordings[0].to = 3.0;
  const Experiment experiment = make_experiment(scenario);
  ASSERT_EQ(experiment.segments.size(), 1u);
  const Segment& segment = experiment.segments[0];
  EXPECT_EQ(segment.count, 201u);
  EXPECT_EQ(segment.time(0), 0.0);
  EXPECT_NEAR(segment.time(200), 2.0, 1e-12);
  EXPECT_NEAR(segment.q0[0], 0.4 - 1.3 + 0.8, 1e-6);
  EXPECT_NEAR(segment.v0[0], -1.3 + 1.6, 1e-4);
}

TEST(Experiment, PrefersStatedNoiseAndAMeasuredStartSpeed) {
  const std::vector<double> time = clock(2.0, 0.01);
  Scenario scenario = bare_scenario(bundled_robot("pendulum/pendulum.urdf"), {});
  add_recording(scenario,
                recording_of(*scenario.robot, Drive{time, {std::vector<double>(time.size(), 0.0)}}, {{0.2}, {0.7}}));
  scenario.noise[ChannelKind::position]["swing"] = 0.123;
  const Experiment experiment = make_experiment(scenario);
  EXPECT_EQ(experiment.channels[0].noise, 0.123);
  EXPECT_TRUE(experiment.channels[0].noise_stated);
  EXPECT_FALSE(experiment.channels[1].noise_stated);
  EXPECT_EQ(experiment.segments[0].v0[0], 0.7);
  EXPECT_EQ(experiment.segments[0].q0[0], 0.2);
}

TEST(Experiment, CountsMeasuredValuesWithoutTheMissingOnes) {
  const std::vector<double> time = clock(1.0, 0.01);
  std::vector<double> q = parabola(time);
  q[10] = q[20] = q[21] = kMissing;
  const Experiment experiment = make_experiment(recorded(time, q));
  EXPECT_EQ(experiment.sample_count(Role::train), time.size() - 3);
  EXPECT_EQ(experiment.sample_count(Role::test), 0u);
  EXPECT_TRUE(experiment.with_role(Role::validate).empty());
}

TEST(Experiment, MeasuresTheSizesThatSearchesAreScaledBy) {
  const std::vector<double> time = clock(20.0, 0.01);
  std::vector<double> q;
  for (const double t : time) q.push_back(2.0 + 0.5 * std::sin(std::numbers::pi * t));
  Scenario scenario = recorded(time, q);
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (double& u : data->columns[data->find("u_swing")]) u = -3.0;
  scenario.recordings[0].data = data;
  const Experiment experiment = make_experiment(scenario);
  EXPECT_NEAR(experiment.command_rms[0], 3.0, 1e-12);
  EXPECT_NEAR(experiment.position_rms[0], 0.5 / std::numbers::sqrt2, 1e-3);
  EXPECT_NEAR(experiment.speed_rms[0], 0.5 * std::numbers::pi / std::numbers::sqrt2, 2e-2);
  EXPECT_NEAR(experiment.sample_period, 0.01, 1e-12);
}

TEST(Experiment, RefusesRecordingsThatAreTooShortAndSaysWhich) {
  const std::vector<double> time = clock(1.0, 0.01);
  Scenario scenario = recorded(time, parabola(time));
  scenario.recordings[0].from = 0.5;
  scenario.recordings[0].to = 0.55;
  std::string message = input_error([&] { make_experiment(scenario); });
  EXPECT_NE(message.find("6 samples"), std::string::npos) << message;
  EXPECT_NE(message.find("run.csv"), std::string::npos) << message;
  EXPECT_NE(message.find("at least 10"), std::string::npos) << message;
  message = input_error([&] { make_experiment(recorded(time, parabola(time), Windows{2.0})); });
  EXPECT_NE(message.find("horizon of 2 s"), std::string::npos) << message;
  EXPECT_NE(message.find("run.csv"), std::string::npos) << message;
}

TEST(Experiment, RefusesAScenarioWithoutRecordingsOrPositions) {
  const std::vector<double> time = clock(1.0, 0.01);
  Scenario scenario = recorded(time, parabola(time));
  scenario.recordings.clear();
  EXPECT_NE(input_error([&] { make_experiment(scenario); }).find("recordings"), std::string::npos);
  scenario = recorded(time, parabola(time));
  scenario.channels.of.erase(ChannelKind::position);
  EXPECT_NE(input_error([&] { make_experiment(scenario); }).find("position"), std::string::npos);
}

}  // namespace
}  // namespace lacuna
