// The missing effort stands at the joint where something is missing, follows what causes it, and is silent without.
#include "diagnosis/locate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.h"
#include "diagnosis/when.h"
#include "ga/random.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kLocateNoise = 3e-4, kLocatePeriod = 0.01, kDryFriction = 0.4;  // rad, s, N m

/// The double pendulum, its recordings made by another engine with what `concealed` adds.
Scenario recorded(const std::vector<EffectSpec>& concealed, double noise = kLocateNoise) {
  const std::map<std::string, double> p{{"gain", 4.0}, {"damping", 1.0}, {"stiffness", 8.0}, {"rest", 0.2}};
  const auto robot = bundled_robot("double_pendulum/double_pendulum.urdf");
  Scenario scenario =
      bare_scenario(robot, {actuator("shoulder", "torque_source", p), actuator("elbow", "torque_source", p)}, false);
  Scenario truth = scenario;
  truth.effects = concealed;
  const Start start{{0.05, 0.1}, {0.0, 0.0}, false};
  add_recording(scenario, simulated_recording(truth, sine_drive(2, 60.0, kLocatePeriod, 3.0), start, engine_of_data(),
                                              "train.csv", noise, 3));
  for (const char* joint : {"shoulder", "elbow"}) scenario.noise[ChannelKind::position][joint] = kLocateNoise;
  return scenario;
}

std::vector<MissingEffort> located(const Scenario& scenario) {
  const PlantModel model(scenario);
  const CurrentModel current{model, SearchSpace(model, scenario), {kLocateNoise, kLocateNoise}, {}};
  return missing_efforts(current, scenario, on("featherstone", 0.002), 1);
}

TEST(MissingEffort, StandsAtTheJointWithFrictionAndFollowsItsDirection) {
  for (const std::string joint : {"shoulder", "elbow"}) {
    SCOPED_TRACE(joint);
    const auto found = located(recorded({effect("coulomb_friction", joint, {{"Fc", kDryFriction}, {"v0", 0.01}})}));
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].joint, joint);
    EXPECT_GT(found[0].share, 0.8);
    EXPECT_LT(found[0].p_value, kLocateError);
    // The friction over the gain of 4 N m/V, its edges smoothed by the filter.
    EXPECT_NEAR(found[0].rms, kDryFriction / 4.0, 0.25 * kDryFriction / 4.0);
    // Beside the speed, which goes with its sign on sines.
    const auto& all = found[0].follows;
    const auto direction = std::find_if(all.begin(), all.end(),
                                        [](const FollowsTest& f) { return f.quantity == "the direction of motion"; });
    ASSERT_NE(direction, all.end());
    EXPECT_LT(direction->correlation, -0.8) << "it acts against the motion";
    EXPECT_EQ(found[0].time.size(), found[0].trace.size());
  }
}

TEST(MissingEffort, IsLargerAtTheEndsThatAHardeningSpringHolds) {
  const auto found = located(recorded({effect("stiffness_hardening", "elbow", {{"k3", 6.0}})}));
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].joint, "elbow");
  const auto& all = found[0].regions;
  EXPECT_TRUE(std::any_of(all.begin(), all.end(),
                          [](const RegionTest& r) { return r.region.find("end of its travel") != std::string::npos; }));
}

TEST(MissingEffort, IsNoiseWhereNothingIsMissing) {
  for (const MissingEffort& m : located(recorded({}))) {
    EXPECT_GT(m.p_value, kLocateError) << m.joint << " " << m.rms << " over " << m.noise;
    EXPECT_TRUE(m.regions.empty());
    EXPECT_TRUE(m.follows.empty());
  }
}

TEST(MissingEffort, KnowsSlowNoiseByItsDifferences) {
  Scenario scenario = recorded({}, 1e-12);
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  constexpr double kKept = 0.8;  // from sample to sample
  for (const char* column : {"q_shoulder", "q_elbow"}) {
    RandomStream random(5, column[2], 0);
    double x = random.normal();
    for (double& q : data->columns[data->find(column)]) {
      q += kLocateNoise * x;
      x = kKept * x + std::sqrt(1.0 - kKept * kKept) * random.normal();
    }
  }
  scenario.recordings[0].data = data;
  for (const MissingEffort& m : located(scenario)) {
    EXPECT_GT(m.p_value, kLocateError) << m.joint;
    // Three standard deviations of the ratio of two rms values over 60 s at 4 Hz.
    EXPECT_NEAR(m.rms / m.noise, 1.0, 3.0 / std::sqrt(60.0 * 2.0 * kLocateCutoff)) << m.joint;
  }
}

/// White noise, `factor` times as large from `from` to `to`.
std::vector<double> louder(std::size_t n, std::size_t from, std::size_t to, double factor, std::uint64_t seed) {
  RandomStream random(seed, 0, 0);
  std::vector<double> out;
  for (std::size_t k = 0; k < n; ++k) out.push_back(random.normal() * (k >= from && k < to ? factor : 1.0));
  return out;
}

TEST(PowerChanges, StandWhereASignalGrowsLouderAndQuieter) {
  const std::vector<double> signal = louder(1000, 300, 600, 3.0, 1);
  const auto changes = power_changes(signal, 1.0);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_NEAR(static_cast<double>(changes[0].at), 300.0, 15.0);
  EXPECT_NEAR(static_cast<double>(changes[1].at), 600.0, 15.0);
  // Three standard errors of an rms over 300 samples.
  EXPECT_NEAR(changes[0].before, 1.0, 3.0 / std::sqrt(600.0));
  EXPECT_NEAR(changes[0].after, 3.0, 9.0 / std::sqrt(600.0));
  EXPECT_DOUBLE_EQ(changes[0].after, changes[1].before);
  EXPECT_LT(changes[0].p_value, 1e-3);
}

TEST(PowerChanges, AreNoneInASignalOfOnePowerWhateverItsColourOrTails) {
  // 200 signals at 1 in 1,000 each: two are expected to be no more than rare.
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    RandomStream random(seed, 1, 0);
    double x = 0.0;
    std::vector<double> signal;
    for (int k = 0; k < 600; ++k) {
      x = 0.8 * x + 0.6 * random.normal();
      signal.push_back(seed % 2 == 0 ? x : x * x * x);
    }
    alarms += !power_changes(signal, 1.0).empty();
  }
  EXPECT_LE(alarms, 2);
}

TEST(PowerChanges, TakeAnySignal) {
  EXPECT_TRUE(power_changes({}, 1.0).empty());
  EXPECT_TRUE(power_changes(std::vector<double>(100, 0.0), 1.0).empty());
  EXPECT_TRUE(power_changes(std::vector<double>(39, 1.0), 1.0).empty());
}

TEST(LikelyJoints, AreThoseBeyondTheNoiseWithAShareOfIt) {
  std::vector<MissingEffort> all(3);
  all[0].joint = "a", all[0].share = 0.9, all[0].p_value = 1e-9;
  all[1].joint = "b", all[1].share = 0.005, all[1].p_value = 1e-9;
  all[2].joint = "c", all[2].share = 0.095, all[2].p_value = 0.2;
  EXPECT_EQ(likely_joints(all), std::vector<std::string>{"a"});
  EXPECT_TRUE(likely_joints({}).empty());
}

TEST(MissingEffort, SaysNothingWhereInverseDynamicsCannotBeHad) {
  Scenario scenario = recorded({});
  scenario.channels.of[ChannelKind::position].erase("elbow");
  EXPECT_TRUE(located(scenario).empty()) << "a commanded joint is not measured";
  scenario = recorded({});
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  data->columns[0][40] += 0.3 * kLocatePeriod;
  scenario.recordings[0].data = data;
  EXPECT_FALSE(located(scenario).empty()) << "an irregular clock is brought onto an even one";
}

}  // namespace
}  // namespace lacuna
