// Errors of the estimated starts: what they do to predictions is known, and no longer taken for anything else.
#include "ga/start_effects.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "ga/problem.h"
#include "tests/ga/plant_problems.h"
#include "tests/physics/hydraulic_plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kNoise = 1e-3;  // rad

/// The pendulum in mid-motion: its speed at the start is known only as well as noise allows.
Scenario moving(double noise, std::uint64_t seed) {
  Scenario truth = pendulum_scenario({}), scenario = pendulum_scenario({});
  add_recording(scenario,
                simulated_recording(truth, sine_drive(1, 6.0, 0.02, 3.0), {{0.1}, {0.8}, false}, "featherstone",
                                    "train.csv", noise, seed),
                Role::train);
  scenario.noise[ChannelKind::position]["swing"] = kNoise;
  return scenario;
}

TEST(StartWhitening, IsTheInverseRootOfTheCovariance) {
  const Eigen::Index rows = 12;
  Eigen::MatrixXd effects(rows, 2);
  Eigen::VectorXd weights(rows), residual(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double x = static_cast<double>(i);
    effects.row(i) << std::exp(-0.3 * x), x * std::exp(-0.2 * x);
    weights(i) = i < 6 ? 0.5 : 2.0;
    residual(i) = std::sin(1.7 * x);
  }
  const Eigen::MatrixXd covariance = Eigen::MatrixXd(weights.cwiseAbs2().asDiagonal()) + effects * effects.transpose();
  const Eigen::VectorXd raw = residual.cwiseProduct(weights);
  Eigen::VectorXd whitened = residual;
  StartWhitening(effects, weights).apply(whitened);
  EXPECT_NEAR(whitened.squaredNorm(), raw.dot(covariance.llt().solve(raw)), 1e-12);
  StartWhitening(effects, weights).undo(whitened);
  EXPECT_LT((whitened - residual).norm(), 1e-12 * residual.norm());
  Eigen::VectorXd untouched = residual;
  StartWhitening().apply(untouched);
  EXPECT_EQ(untouched, residual);
  EXPECT_THROW(StartWhitening(effects, Eigen::VectorXd::Ones(rows - 1)), std::invalid_argument);
}

TEST(StartEffects, LeaveAtTheTruthWhatNoiseAloneLeaves) {
  // Chi-square over recordings: the starts taken as exact, their errors show; whitened, as many units as samples.
  double exact = 0.0, whitened = 0.0, samples = 0.0;
  constexpr int kRecordings = 40;
  for (int k = 0; k < kRecordings; ++k) {
    const Scenario scenario = moving(kNoise, static_cast<std::uint64_t>(k) + 1);
    const PlantModel model(scenario);
    Experiment experiment = make_experiment(scenario);
    const SimulatorOptions options = on("featherstone", 0.005);
    ASSERT_TRUE(attach_start_effects(experiment, model, options, model.values()));
    Problem problem(model, experiment, SearchSpace(model, scenario), options, {kNoise});
    const std::vector<std::vector<double>> one{model.values()};
    const int segment[] = {0};
    exact += problem.plain_residuals_of(one, segment).front().squaredNorm();
    const Eigen::VectorXd r = problem.residuals_of(one, segment).front();
    whitened += r.squaredNorm();
    samples += static_cast<double>(r.size());
  }
  const double error = std::sqrt(2.0 * samples);  // of a chi-square
  EXPECT_GT(exact, samples + 6.0 * error) << "nothing was tested";
  EXPECT_LT(whitened, samples + 3.0 * error);
  // The start is estimated from the recording's own first readings: up to its two coordinates' units may be missing.
  EXPECT_GT(whitened, samples - 2.0 * kRecordings - 3.0 * error);
}

TEST(StartEffects, CarryThePressuresNoiseThatDrivesAJoint) {
  // A block under constant pressures that are read with noise, its start known.
  using namespace test::hydraulic;
  constexpr double kPressureNoise = 50.0, kPositionNoise = 2e-4;  // Pa, m
  const double a = 10 * kBar * kArea / kBlockMass;
  double exact = 0.0, whitened = 0.0, samples = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Noise noise(seed);
    Scenario scenario = pressed(
        block_robot(), symmetric(), [&](double) { return 20 * kBar + kPressureNoise * noise(); },
        [&](double) { return 10 * kBar + kPressureNoise * noise(); });
    scenario.channels.of.erase(ChannelKind::velocity), scenario.channels.of.erase(ChannelKind::effort);
    auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
    auto& q = data->columns[static_cast<std::size_t>(data->find("q_slide"))];
    const auto& t = data->columns[static_cast<std::size_t>(data->find("t"))];
    for (std::size_t k = 0; k < t.size(); ++k) q[k] = 0.5 * a * t[k] * t[k] + kPositionNoise * noise();
    scenario.recordings[0].data = data;
    scenario.noise[ChannelKind::position]["slide"] = kPositionNoise;
    scenario.noise[ChannelKind::pressure_a]["slide"] = scenario.noise[ChannelKind::pressure_b]["slide"] =
        kPressureNoise;
    const PlantModel model(scenario);
    Experiment experiment = started_experiment(scenario, {{0.0}, {0.0}});
    for (Segment& segment : experiment.segments) segment.q0_error = segment.v0_error = {0.0};
    const SimulatorOptions options = on("featherstone", 0.005);
    ASSERT_TRUE(attach_start_effects(experiment, model, options, model.values()));
    Problem problem(model, experiment, SearchSpace(model, scenario), options, {kPositionNoise});
    const std::vector<std::vector<double>> one{model.values()};
    const int segment[] = {0};
    exact += problem.plain_residuals_of(one, segment).front().squaredNorm();
    const Eigen::VectorXd r = problem.residuals_of(one, segment).front();
    whitened += r.squaredNorm();
    samples += static_cast<double>(r.size());
  }
  const double error = std::sqrt(2.0 * samples);  // of a chi-square
  EXPECT_GT(exact, 4.0 * samples) << "nothing was tested";
  EXPECT_LT(whitened, samples + 3.0 * error);
  EXPECT_GT(whitened, samples - 3.0 * error);
}

TEST(Problem, RowsInOtherWeightsAreThoseOfAProblemThatHasThem) {
  Scenario scenario = moving(kNoise, 5);
  for (const char* name : {"gain", "stiffness"}) scenario.identify.push_back({name, true, 0.2, 5.0, "test"});
  const PlantModel model(scenario);
  Experiment experiment = make_experiment(scenario);
  const SimulatorOptions options = on("featherstone", 0.005);
  ASSERT_TRUE(attach_start_effects(experiment, model, options, model.values())) << "whitening is more than a scale";
  const SearchSpace space(model, scenario);
  Problem fine(model, experiment, space, options, {kNoise}), coarse(model, experiment, space, options, {7.0 * kNoise});
  const std::vector<double> point = space.start();
  const std::vector<int> train = experiment.with_role(Role::train);
  const auto rows = [&](Problem& problem) {
    const Eigen::VectorXd at = problem.residual(point, train);
    Eigen::MatrixXd out(at.size(), static_cast<Eigen::Index>(1 + space.size()));
    out << at, problem.jacobian(point, at, train);
    return out;
  };
  const Eigen::MatrixXd wanted = rows(coarse), given = coarse.reweighed(rows(fine), fine, train);
  // Differences of 1e-6 over rounding of 1e-16.
  EXPECT_LT((given - wanted).norm(), 1e-8 * wanted.norm());
  EXPECT_GT((given - rows(fine) / 7.0).norm(), 1e-3 * wanted.norm()) << "a scale alone would have done";
}

TEST(StartEffects, AreNoneWhereNothingIsUncertain) {
  const Scenario scenario = moving(0.0, 1);
  const PlantModel model(scenario);
  Experiment experiment = make_experiment(scenario);
  for (Segment& segment : experiment.segments) segment.q0_error = segment.v0_error = {0.0};
  EXPECT_FALSE(attach_start_effects(experiment, model, on("featherstone", 0.005), model.values()));
  EXPECT_EQ(experiment.segments[0].start_effects, nullptr);
}

}  // namespace
}  // namespace lacuna
