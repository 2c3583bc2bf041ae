// The plain model's fit: which ways it takes, and that it ends as low by either.
#include "diagnosis/baseline.h"

#include <gtest/gtest.h>

#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr int kGenerations = 6;

struct PlainEnd {
  CurrentModel model;
  FitResult fit;
};

PlainEnd plain_end(const Scenario& scenario) {
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  IdentifyOptions options;
  options.step = 0.005;
  options.genetic.population = 20, options.genetic.generations = kGenerations;
  FitResult fit;
  const CurrentModel current = identify_plain(model, experiment, SearchSpace(model, scenario), options, fit);
  return {current, std::move(fit)};
}

/// A pendulum with friction, its damping and its spring's stiffness as guessed.
Scenario rubbing(double damping, double stiffness) {
  Scenario scenario = pendulum_problem({3.0, damping, stiffness, 1.0}, {"gain", "damping", "stiffness"}, 1e-3,
                                       {effect("coulomb_friction", "swing", {{"Fc", 0.1}})}, 8.0, engine_of_data());
  for (IdentifySpec& spec : scenario.identify) spec.lower = 0.02, spec.upper = 50.0;
  return scenario;
}

TEST(IdentifyPlain, NeedsNoPopulationWhereTwoDescentsMeet) {
  const PlainEnd end = plain_end(rubbing(0.8, 6.0));
  EXPECT_TRUE(end.fit.history.empty());
  EXPECT_EQ(end.fit.optimizer, "lsq");
  EXPECT_NEAR(end.model.space.expand(end.model.fit.point)[0], 3.0, 0.3) << "the gain, with friction left out";
}

/// Guessed a hundred times too stiff and hardly damped, it rings on its own: descents from there end alike, in silence.
TEST(IdentifyPlain, SearchesAPopulationWhereDescentsFindLittleOfTheMotion) {
  const PlainEnd end = plain_end(rubbing(0.02, 400.0));
  EXPECT_EQ(end.fit.history.size(), static_cast<std::size_t>(kGenerations));
  EXPECT_EQ(end.fit.optimizer, "ga+lsq");
}

/// A pendulum on a spring so stiff that it rings twenty times a second.
Scenario ringing() {
  constexpr double kNoise = 3e-3;  // rad
  Scenario scenario = pendulum_scenario({1700.0, 7.0, 4500.0});
  const Scenario truth = pendulum_scenario({2000.0, 6.0, 4000.0});
  add_recording(scenario,
                simulated_recording(truth, rested_drive(30.0, 0.0), {{0.0}, {0.0}, false}, engine_of_data(), "run.csv",
                                    kNoise, 11),
                Role::train);
  for (const char* name : {"gain", "damping", "stiffness"})
    scenario.identify.push_back({name, true, 0.2, 5.0, std::string("test: identify.") + name});
  scenario.noise[ChannelKind::position]["swing"] = kNoise;
  return scenario;
}

/// Fitted at a step whose error stays under a tenth of the noise, as choose_step asks.
struct FittedAtATenth {
  Setting s{ringing()};
  StepChoice step = choose_step(s.model, s.experiment, on("featherstone", 1.0), s.model.values());
  FitContext context{s.experiment, on("featherstone", step.step), {}};
  CurrentModel model{s.model, s.space, first_weights(s.model, s.experiment), {}};

  FittedAtATenth() {
    model.fit.point = s.space.start();
    refine(model, context);
  }
  CurrentModel at(double other_step) const {
    CurrentModel out = model;
    refine(out, context.with_step(other_step));
    return out;
  }
  /// Largest distance of two fits, in standard errors.
  double apart(const CurrentModel& a, const CurrentModel& b) const {
    const Identifiability known = identifiability(a.space, a.fit.point, a.fit.jacobian, 1.0, 1.0);
    double most = 0.0;
    for (std::size_t k = 0; k < a.fit.point.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      most = std::max(most, std::fabs(a.fit.point[k] - b.fit.point[k]) / std::sqrt(known.covariance(i, i)));
    }
    return most;
  }
};

TEST(Settle, TheShiftByIntegrationIsHowFarAFinerStepMovesTheFit) {
  FittedAtATenth f;
  Problem problem(f.model.model, f.s.experiment, f.model.space, f.context.simulator, f.model.weights);
  const double shift = shift_by_integration(problem, f.s.train, f.model.fit);
  EXPECT_LT(f.step.error_over_noise, 0.1);
  EXPECT_GT(shift, 0.3) << "the predictions' rule leaves the numbers further off than a standard error's fifth";
  EXPECT_NEAR(shift, f.apart(f.model, f.at(f.step.step / 8.0)), 2.0 * std::sqrt(0.05))
      << "either fit may end where .05 of chi-square is left to gain";
}

TEST(Settle, LeavesTheNumbersWhereAFinerStepWouldPutThem) {
  FittedAtATenth f;
  const CurrentModel finest = f.at(f.step.step / 16.0);
  ASSERT_GT(f.apart(f.model, finest), 0.3);
  const double step = settle(f.model, f.context);
  EXPECT_LT(step, f.step.step);
  Problem problem(f.model.model, f.s.experiment, f.model.space, on("featherstone", step), f.model.weights);
  EXPECT_LE(shift_by_integration(problem, f.s.train, f.model.fit), 0.2);
  EXPECT_LT(f.apart(f.model, finest), 0.25);
}

}  // namespace
}  // namespace lacuna
