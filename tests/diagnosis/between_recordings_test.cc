// Numbers that differ between recordings are seen, in their size; what is alike in all of them is not.
#include "diagnosis/between_recordings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "diagnosis/baseline.h"
#include "diagnosis/hypothesis.h"
#include "tests/diagnosis/outside.h"

namespace lacuna {
namespace {

using namespace test;

const std::vector<Role> kRoles{Role::train, Role::train, Role::train, Role::validate, Role::test};

/// The plain pendulum, from wrong numbers, on recordings of one that has in each the effects that `in` gives it.
Scenario differing(const std::function<std::vector<EffectSpec>(std::size_t)>& in) {
  Scenario scenario = pendulum_scenario(kGuessed);
  for (std::size_t k = 0; k < kRoles.size(); ++k) {
    Scenario truth = pendulum_scenario({});
    truth.effects = in(k);
    const std::string file = "run_" + std::to_string(k + 1) + ".csv";
    const Drive drive = rested_drive(kRecordedFor, 7.3 * static_cast<double>(k));
    add_recording(scenario, recording_with({}, truth, drive, file, 11 + k), kRoles[k]);
  }
  search_plain_numbers(scenario);
  return scenario;
}
/// One that has `effects` and in each recording an offset of its own.
Scenario with_offsets(const std::vector<double>& offsets, const std::vector<EffectSpec>& effects = {}) {
  return differing([&](std::size_t k) {
    std::vector<EffectSpec> out = effects;
    out.push_back({"valve_offset", "swing", {{"b", offsets[k]}}, {}, "test"});
    return out;
  });
}

/// Beside the plain model with one number of the effect for all, fitted to the train recordings.
std::vector<NumberByRecording> seen_in(const Scenario& scenario, const std::vector<std::string>& joints = {"swing"},
                                       const std::string& effect = "valve_offset", double start = 0.0) {
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  FitResult fit;
  const CurrentModel plain = identify_plain(model, experiment, space, options, fit);
  const FitContext context{experiment, on("featherstone", 0.005)};
  CurrentModel current = plain;
  for (const std::string& joint : joints)
    current = extended(current, experiment, {effect, joint, {}, {}, "test"}, current.fit.point, {start});
  EXPECT_TRUE(refit(current, context));
  return numbers_by_recording(current, context, joints);
}

TEST(BetweenRecordings, OffsetsThatDifferAreSeenInTheirSize) {
  const std::vector<double> truth{0.05, -0.03, 0.01, 0.07, -0.2};
  const std::vector<NumberByRecording> seen = seen_in(with_offsets(truth));
  ASSERT_EQ(seen.size(), 1u);
  const NumberByRecording& offsets = seen.front();
  EXPECT_EQ(offsets.joint, "swing");
  EXPECT_EQ(offsets.number, "valve_offset.b");
  ASSERT_EQ(offsets.recordings.size(), 4u) << "test recordings say nothing";
  double mean = 0.0, given = 0.0;
  for (std::size_t k = 0; k < 4; ++k) mean += 0.25 * offsets.recordings[k].second, given += 0.25 * truth[k];
  // What is a thousandth of a radian's noise over 1000 samples of some .2 rad/V, and what linearity leaves.
  constexpr double kWithin = 0.004;
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(offsets.recordings[k].second - mean, truth[k] - given, kWithin) << offsets.recordings[k].first;
  EXPECT_GT(offsets.deviation, 0.02);
  EXPECT_LT(offsets.deviation, 0.1);
  EXPECT_GT(offsets.share, 0.8) << "all but the noise's own";
}

/// Edges move, the null does not: what explains the most goes first, and little is left for another.
TEST(BetweenRecordings, ADeadZoneThatDiffersIsTheNumberThatMoves) {
  const std::vector<double> truth{0.30, 0.42, 0.36, 0.24, 0.3};
  const Scenario scenario = differing([&](std::size_t k) {
    return std::vector<EffectSpec>{{"valve_deadband", "swing", {{"d", truth[k]}}, {}, "test"}};
  });
  const std::vector<NumberByRecording> seen = seen_in(scenario, {"swing"}, "valve_deadband", 0.35);
  ASSERT_FALSE(seen.empty());
  const NumberByRecording& edges = seen.front();
  EXPECT_EQ(edges.number, "valve_deadband.d");
  EXPECT_EQ(edges.unit, "cmd") << "the pendulum's scenario names none";
  EXPECT_NEAR(edges.value, 0.36, 0.06) << "about the mean of the train recordings";
  const double mean = std::accumulate(truth.begin(), truth.end() - 1, 0.0) / 4.0;
  double given = 0.0;
  for (const auto& [file, beyond] : edges.recordings) given += 0.25 * beyond;
  constexpr double kWithin = 0.006;  // a tenth of what differs: what linearity leaves
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(edges.recordings[k].second - given, truth[k] - mean, kWithin) << edges.recordings[k].first;
  EXPECT_GT(edges.share, 0.8);
  for (const NumberByRecording& other : seen) EXPECT_TRUE(&other == &edges || other.share < 0.05) << other.number;
}

TEST(BetweenRecordings, AnOffsetThatAllShareIsNone) {
  EXPECT_TRUE(seen_in(with_offsets({0.1, 0.1, 0.1, 0.1, 0.1})).empty());
}

/// Two joints in one recording: halves are of its time, not of its joints.
TEST(BetweenRecordings, OffsetsAreTheirJoints) {
  std::vector<EffectSpec> offsets;
  const std::vector<double> truth{0.05, -0.03, 0.01, 0.07};
  for (std::size_t k = 0; k < truth.size(); ++k)
    offsets.push_back(
        {"valve_offset", "swing", {{"b", truth[k]}}, {k == 0 ? "run.csv" : fmt::format("run_{}.csv", k)}, "test"});
  Scenario scenario = two_machines(offsets, {Role::train, Role::train, Role::train, Role::validate}, kTransducerNoise);
  search_plain_numbers(scenario);
  const std::vector<NumberByRecording> seen = seen_in(scenario, {"slide", "swing"});
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen.front().joint, "swing");
}

/// From end to end: beside the offset that the model has for all.
TEST(BetweenRecordings, AreSaidInADiagnosis) {
  const Diagnosis d = diagnosed(with_offsets({0.05, -0.03, 0.01, 0.07, 0.0}));
  EXPECT_TRUE(d.unexplained.present);
  ASSERT_EQ(d.unexplained.numbers.size(), 1u);
  EXPECT_EQ(d.unexplained.numbers.front().joint, "swing");
  EXPECT_EQ(d.unexplained.numbers.front().recordings.size(), 4u);
}

/// Friction that the model lacks leaves more than offsets of some noise would, and is the same in all recordings.
TEST(BetweenRecordings, ALawThatIsMissingInAllOfThemIsNone) {
  const EffectSpec friction{"coulomb_friction", "swing", {{"Fc", 0.3}}, {}, "test"};
  EXPECT_TRUE(seen_in(with_offsets({0.0, 0.0, 0.0, 0.0, 0.0}, {friction})).empty());
}

}  // namespace
}  // namespace lacuna
