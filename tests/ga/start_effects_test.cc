// Errors of the estimated starts: what they do to predictions is known, and no longer taken for anything else.
#include "ga/start_effects.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "ga/identify.h"
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

/// Squared errors of an identified gain and damping, summed over recordings.
struct SquaredErrors {
  double relative = 0.0, standardised = 0.0;  ///< over the value, over what their intervals say
};
SquaredErrors identified(bool start_errors) {
  SquaredErrors out;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Scenario scenario = moving(kNoise, seed);
    for (const char* name : {"gain", "damping", "stiffness"})
      scenario.identify.push_back({name, true, 0.2, 5.0, "test"});
    const PlantModel truth(scenario);
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.start_errors = start_errors;
    const FitResult fit = identify(truth, make_experiment(scenario), SearchSpace(truth, scenario), options);
    for (const Estimate& e : fit.estimates) {
      if (e.name == "swing.stiffness") continue;  // its error is that of the gain
      const double right = truth.values()[truth.find(e.name)];
      out.relative += std::pow(e.value / right - 1.0, 2);
      out.standardised += std::pow((e.value - right) / ((e.upper95 - e.lower95) / (2.0 * 1.96)), 2);
    }
  }
  return out;
}

TEST(StartEffects, AreTakenUpByNothingThatIsIdentified) {
  const SquaredErrors with = identified(true), without = identified(false);
  // Chi-square of 24 standardised errors: 1 in 1,000 above 51.2, and below 7.5.
  EXPECT_LT(with.standardised, 51.2);
  EXPECT_GT(with.standardised, 7.5);
  EXPECT_LT(with.relative, 0.1 * without.relative) << "taken as exact the starts move the parameters";
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

/// Chi-square at the truth over recordings: with starts and pressures taken as exact, and whitened by their errors,
/// which must leave as many units as there are samples.
struct ChiSquare {
  double exact = 0.0, whitened = 0.0, samples = 0.0;

  void add(const Scenario& scenario, Experiment experiment) {
    const PlantModel model(scenario);
    const SimulatorOptions options = on("featherstone", 0.005);
    ASSERT_TRUE(attach_start_effects(experiment, model, options, model.values()));
    std::vector<double> noise;
    for (const Channel& channel : experiment.channels) noise.push_back(channel.noise);
    Problem problem(model, experiment, SearchSpace(model, scenario), options, noise);
    const std::vector<std::vector<double>> one{model.values()};
    const int segment[] = {0};
    exact += problem.plain_residuals_of(one, segment).front().squaredNorm();
    const Eigen::VectorXd r = problem.residuals_of(one, segment).front();
    whitened += r.squaredNorm();
    samples += static_cast<double>(r.size());
  }
  double error() const { return std::sqrt(2.0 * samples); }
};
constexpr int kRecordings = 40;

TEST(StartEffects, LeaveAtTheTruthWhatNoiseAloneLeaves) {
  ChiSquare sum;
  for (int k = 0; k < kRecordings; ++k) {
    const Scenario scenario = moving(kNoise, static_cast<std::uint64_t>(k) + 1);
    sum.add(scenario, make_experiment(scenario));
  }
  EXPECT_GT(sum.exact, sum.samples + 6.0 * sum.error()) << "nothing was tested";
  EXPECT_LT(sum.whitened, sum.samples + 3.0 * sum.error());
  // The start is estimated from the recording's own first readings: up to its two coordinates' units may be missing.
  EXPECT_GT(sum.whitened, sum.samples - 2.0 * kRecordings - 3.0 * sum.error());
}

/// The experiment with its start known.
Experiment exactly_started(const Scenario& scenario) {
  Experiment out = started_experiment(scenario, {{0.0}, {0.0}});
  for (Segment& segment : out.segments) segment.q0_error = segment.v0_error = {0.0};
  return out;
}

/// One joint's positions, which follow `course`, and pressures about `head` and `rod`, all read with noise.
Scenario read_with_noise(std::shared_ptr<const Robot> robot, std::uint64_t seed, double position_noise,
                         double pressure_noise, double head, double rod, const std::function<double(double)>& course) {
  using namespace test::hydraulic;
  Noise noise(seed);
  Scenario out = pressed(
      std::move(robot), symmetric(), [&](double) { return head + pressure_noise * noise(); },
      [&](double) { return rod + pressure_noise * noise(); });
  out.channels.of.erase(ChannelKind::velocity), out.channels.of.erase(ChannelKind::effort);
  const std::string& joint = out.robot->joints()[0].name;
  auto data = std::make_shared<Recording>(*out.recordings[0].data);
  const std::vector<double> t = data->columns[data->find("t")];
  auto& q = data->columns[data->find("q_" + joint)];
  for (std::size_t k = 0; k < t.size(); ++k) q[k] = course(t[k]) + position_noise * noise();
  std::ranges::fill(data->columns[data->find("u_" + joint)], 0.0);
  out.recordings[0].data = data;
  out.noise[ChannelKind::position][joint] = position_noise;
  out.noise[ChannelKind::pressure_a][joint] = out.noise[ChannelKind::pressure_b][joint] = pressure_noise;
  return out;
}

TEST(StartEffects, CarryThePressuresNoiseThatDrivesAJoint) {
  // A block under constant pressures, whose commands say nothing.
  using namespace test::hydraulic;
  const double a = 10 * kBar * kArea / kBlockMass;
  ChiSquare sum;
  for (std::uint64_t seed = 1; seed <= kRecordings; ++seed) {
    const Scenario scenario = read_with_noise(block_robot(), seed, 2e-4, 50.0, 20 * kBar, 10 * kBar,
                                              [&](double t) { return 0.5 * a * t * t; });
    sum.add(scenario, exactly_started(scenario));
  }
  EXPECT_GT(sum.exact, 4.0 * sum.samples) << "nothing was tested";
  EXPECT_LT(sum.whitened, sum.samples + 3.0 * sum.error());
  EXPECT_GT(sum.whitened, sum.samples - 3.0 * sum.error());
}

TEST(StartEffects, CarryTheNoiseOfThePressuresAtTheStart) {
  // A rotor at rest behind a closed valve: its pressures are predicted from one noisy sample each.
  using namespace test::hydraulic;
  ChiSquare sum;
  for (std::uint64_t seed = 1; seed <= kRecordings; ++seed) {
    Scenario scenario = read_with_noise(rotor(), seed, 3e-4, 1e4, 60 * kBar, 60 * kBar, [](double) { return 0.0; });
    scenario.pressure_driven = false;
    sum.add(scenario, exactly_started(scenario));
  }
  EXPECT_GT(sum.exact, sum.samples + 6.0 * sum.error()) << "nothing was tested";
  EXPECT_LT(sum.whitened, sum.samples + 3.0 * sum.error());
  // The first sample of either pressure is the start itself, and leaves nothing.
  EXPECT_GT(sum.whitened, sum.samples - 2.0 * kRecordings - 3.0 * sum.error());
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
    Eigen::MatrixXd out(at.size(), 1 + space.size());
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
