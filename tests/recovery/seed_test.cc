// Planted truth must be recovered: the seed's nine parameters of joint 2, up to what angles identify, on every engine.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kStep = 0.01;  // s, as sampled: joint 2 swings at some 14 rad/s
constexpr double kNoise = 3e-4;  // rad, rms, in the bundled recordings
constexpr double kShare = 0.01;  // of the truth; standard errors are some .1 %
const std::vector<std::string> kTables{"table1", "table5"};

/// The bundled preset with its recordings (Simbody's accelerations, Dormand-Prince, noise of 3e-4 rad), or its truth.
Scenario loaded(const std::string& file, bool recordings) {
  ScenarioOptions options;
  options.load_recordings = recordings;
  return load_scenario(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek" / file, options);
}

/// What joint 2's angle identifies: effort terms over stiffness.
struct Combinations {
  double gain, damping, inertia, gravity;
};
Combinations combinations(const PlantModel& model, const std::vector<double>& values) {
  auto value = [&](const std::string& name) { return values[static_cast<std::size_t>(model.find(name))]; };
  auto dynamics = find_engine("featherstone").build(model.robot_ptr(), model.gravity());
  const std::vector<Inertial> inertials = model.inertials(values);
  for (int i = 0; i < model.dof(); ++i) dynamics->set_inertial(i, inertials[static_cast<std::size_t>(i)]);
  const std::vector<double> q{0.0, 0.4, 0.0, 0.0, 0.0, 0.0}, zero(6, 0.0);
  std::vector<double> tau(6);
  dynamics->inverse_dynamics(q, zero, zero, tau);
  Eigen::MatrixXd mass;
  dynamics->mass_matrix(q, mass);
  const double s = value("joint_2.stiffness");
  return {value("joint_2.gain") / s, value("joint_2.damping") / s, mass(1, 1) / s, tau[1] / s};
}

class SeedRecovery : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(SeedRecovery, FindsWhatAnglesIdentifyInTheBundledRecordings) {
  const auto& [engine, table] = GetParam();
  const Scenario scenario = loaded("joint_2_" + table + ".yaml", true);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  IdentifyOptions options;
  options.simulator.engine = engine;
  options.simulator.threads = 2;
  options.step = kStep;
  // Without lanes a simulation costs up to a hundred times as much: a smaller search, the same finish.
  options.genetic.population = engine == "featherstone" ? 70 : 12;
  options.genetic.generations = engine == "featherstone" ? 30 : 3;
  const FitResult fit = identify(model, experiment, space, options);
  const PlantModel truth_model(loaded("joint_2_" + table + "/truth.yaml", false));
  const Combinations found = combinations(model, fit.values), truth = combinations(truth_model, truth_model.values());
  EXPECT_NEAR(found.gain, truth.gain, kShare * truth.gain) << engine << " " << table;
  EXPECT_NEAR(found.damping, truth.damping, kShare * truth.damping) << engine << " " << table;
  EXPECT_NEAR(found.inertia, truth.inertia, kShare * truth.inertia) << engine << " " << table;
  EXPECT_NEAR(found.gravity, truth.gravity, kShare * truth.gravity) << engine << " " << table;
  const double size = fit.rms.front().second.front().second / kNoise;
  EXPECT_NEAR(size, 1.0, 0.05) << engine << " " << table << ": rms of the residual over that of the noise";
  EXPECT_FALSE(fit.undetermined.empty()) << "the common factor must be named";
}

INSTANTIATE_TEST_SUITE_P(Engines, SeedRecovery,
                         testing::Combine(testing::ValuesIn(available_engines()), testing::ValuesIn(kTables)),
                         [](const auto& p) { return std::get<0>(p.param) + "_" + std::get<1>(p.param); });

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
  options.genetic.population = 30;
  options.genetic.generations = 10;
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
    options.genetic.population = 20;
    options.genetic.generations = 5;
    fits.push_back(identify(model, experiment, space, options));
  }
  EXPECT_EQ(fits[0].search_cost, fits[1].search_cost);
  EXPECT_TRUE(same_bits(fits[0].values, fits[1].values));
}

}  // namespace
}  // namespace lacuna
