// Planted truth must be recovered: the seed's nine parameters of joint 2, up to what angles identify, on every engine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kStep = 0.01;            // s, as sampled: joint 2 swings at some 14 rad/s
constexpr double kNoise = 3e-4;           // rad, rms, in the bundled recordings
constexpr double kShare = 0.01;           // of the truth; standard errors are some .1 %
constexpr double kNoiseFreeShare = 2e-3;  // of the truth: integration at kStep, and ODE's accelerations
const std::vector<std::string> kTables{"table1", "table5"};

// Sanitized code is some thirty times slower: the same paths over fewer seconds and a smaller search.
#if defined(__SANITIZE_ADDRESS__)
constexpr double kSeconds = 5.0;
constexpr int kPopulation = 14, kGenerations = 4;
#else
constexpr double kSeconds = 20.0;
constexpr int kPopulation = 70, kGenerations = 30;
#endif

/// The bundled preset with its recordings (Simbody's accelerations, Dormand-Prince, noise of 3e-4 rad), or its truth.
Scenario loaded(const std::string& file, bool recordings) {
  ScenarioOptions options;
  options.load_recordings = recordings;
  Scenario scenario = load_scenario(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek" / file, options);
  for (RecordingSpec& recording : scenario.recordings) recording.to = kSeconds;
  return scenario;
}

/// What joint 2's angle identifies: effort terms over stiffness.
struct Combinations {
  double gain, damping, inertia, gravity;
};
Combinations combinations(const PlantModel& model, const std::vector<double>& values) {
  auto value = [&](const std::string& name) { return values[model.find(name)]; };
  auto dynamics = find_engine("featherstone").build(model.robot_ptr(), model.gravity());
  const std::vector<Inertial> inertials = model.inertials(values);
  for (int i = 0; i < model.dof(); ++i) dynamics->set_inertial(i, inertials[i]);
  const std::vector<double> q{0.0, 0.4, 0.0, 0.0, 0.0, 0.0}, zero(6, 0.0);
  std::vector<double> tau(6);
  dynamics->inverse_dynamics(q, zero, zero, tau);
  Eigen::MatrixXd mass;
  dynamics->mass_matrix(q, mass);
  const double s = value("joint_2.stiffness");
  return {value("joint_2.gain") / s, value("joint_2.damping") / s, mass(1, 1) / s, tau[1] / s};
}

void expect_recovered(const FitResult& fit, const PlantModel& model, const std::string& table, double share) {
  const PlantModel truth_model(loaded("joint_2_" + table + "/truth.yaml", false));
  const Combinations found = combinations(model, fit.values), truth = combinations(truth_model, truth_model.values());
  EXPECT_NEAR(found.gain, truth.gain, share * truth.gain);
  EXPECT_NEAR(found.damping, truth.damping, share * truth.damping);
  EXPECT_NEAR(found.inertia, truth.inertia, share * truth.inertia);
  EXPECT_NEAR(found.gravity, truth.gravity, share * truth.gravity);
  EXPECT_FALSE(fit.undetermined.empty()) << "the common factor must be named";
}

/// The preset with 2.5 s of noise-free data of another engine in place of its recordings: sines after half a second at
/// rest in the truth's equilibrium.
Scenario noise_free(const std::string& table, const std::string& maker) {
  Scenario scenario = loaded("joint_2_" + table + ".yaml", false);
  const Scenario truth = loaded("joint_2_" + table + "/truth.yaml", false);
  Scenario plant = bare_scenario(truth.robot, truth.actuators, false);
  plant.effects = truth.effects;
  Start start{std::vector<double>(6, 0.0), std::vector<double>(6, 0.0), false};
  const auto settled = simulated_recording(plant, constant_drive(6, 10.0, 0.1, 0.0), start, "featherstone", "rest.csv",
                                           0.0, 1, 0.5 * kStep);
  start.q[1] = settled->columns[settled->find("q_joint_2")].back();
  Drive drive = constant_drive(6, 2.5, kStep, 0.0);
  const Drive sines = sine_drive(6, 2.5, kStep, 6.0);
  for (std::size_t k = 50; k < drive.time.size(); ++k) drive.u[1][k] = sines.u[1][k];
  const auto data = simulated_recording(plant, drive, start, maker, "train.csv", 0.0, 1, 0.5 * kStep);
  scenario.channels.of[ChannelKind::position] = {{"joint_2", plant.channels.of[ChannelKind::position].at("joint_2")}};
  scenario.channels.of[ChannelKind::command] = {{"joint_2", plant.channels.of[ChannelKind::command].at("joint_2")}};
  scenario.channels.time = plant.channels.time;
  scenario.recordings.clear();
  add_recording(scenario, data, Role::train);
  scenario.noise[ChannelKind::position]["joint_2"] = 1e-5;  // rad: what a fine encoder resolves
  return scenario;
}

class SeedRecovery : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(SeedRecovery, FindsWhatAnglesIdentifyInNoiseFreeDataOfAnotherEngine) {
  const auto& [engine, table] = GetParam();
  std::string maker = "featherstone";
  for (const std::string& other : available_engines()) {
    if (engine == "featherstone" && (other == "simbody" || other == "mujoco")) maker = other;
  }
  const Scenario scenario = noise_free(table, maker);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  IdentifyOptions options;
  options.simulator.engine = engine;
  options.simulator.threads = 2;
  options.step = kStep;
  // Without lanes a simulation costs up to a hundred times as much: a smaller search, the same finish.
  options.genetic.population = engine == "featherstone" ? 30 : 12;
  options.genetic.generations = engine == "featherstone" ? 10 : 3;
  expect_recovered(identify(model, experiment, space, options), model, table, kNoiseFreeShare);
}

INSTANTIATE_TEST_SUITE_P(Engines, SeedRecovery,
                         testing::Combine(testing::ValuesIn(available_engines()), testing::ValuesIn(kTables)),
                         [](const auto& p) { return std::get<0>(p.param) + "_" + std::get<1>(p.param); });

TEST(SeedRecoveryBundled, FindsWhatAnglesIdentifyInTheBundledRecordings) {
  for (const std::string& table : kTables) {
    SCOPED_TRACE(table);
    const Scenario scenario = loaded("joint_2_" + table + ".yaml", true);
    const PlantModel model(scenario);
    const Experiment experiment = make_experiment(scenario);
    const SearchSpace space(model, scenario);
    IdentifyOptions options;
    options.simulator.threads = 2;
    options.step = kStep;
    options.genetic.population = kPopulation;
    options.genetic.generations = kGenerations;
    const FitResult fit = identify(model, experiment, space, options);
    expect_recovered(fit, model, table, kShare);
    // Three standard errors of an rms of so many samples.
    const double spread = 3.0 / std::sqrt(2.0 * kSeconds / kStep);
    EXPECT_NEAR(fit.rms.front().second.front().second, kNoise, spread * kNoise) << "the residual is the noise";
  }
}

TEST(SeedRecoveryConstraint, HonoursAKnownTotalMassExactly) {
  Scenario scenario = loaded("joint_2_table1.yaml", true);
  const PlantModel truth_model(loaded("joint_2_table1/truth.yaml", false));
  const std::vector<double> masses = truth_model.link_masses(truth_model.values());
  scenario.total_mass = std::accumulate(masses.begin(), masses.end(), 0.0);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  IdentifyOptions options;
  options.step = kStep;
  options.genetic.population = std::min(kPopulation, 30);
  options.genetic.generations = std::min(kGenerations, 10);
  const FitResult fit = identify(model, experiment, space, options);
  const std::vector<double> found = model.link_masses(fit.values);
  EXPECT_NEAR(std::accumulate(found.begin(), found.end(), 0.0), *scenario.total_mass, 1e-12 * *scenario.total_mass);
  EXPECT_TRUE(std::any_of(fit.estimates.begin(), fit.estimates.end(), [](const Estimate& e) { return e.derived; }));
}

TEST(SeedRecoveryDeterminism, GeneticSearchGivesTheSameBitsOnOneAndTwoThreads) {
  const Scenario scenario = loaded("joint_2_table1.yaml", true);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  std::vector<FitResult> fits;
  for (const int threads : {1, 2}) {
    IdentifyOptions options;
    options.step = kStep;
    options.simulator.threads = threads;
    options.genetic.population = std::min(kPopulation, 20);
    options.genetic.generations = std::min(kGenerations, 5);
    fits.push_back(identify(model, experiment, space, options));
  }
  EXPECT_EQ(fits[0].search_cost, fits[1].search_cost);
  EXPECT_TRUE(same_bits(fits[0].values, fits[1].values));
}

}  // namespace
}  // namespace lacuna
