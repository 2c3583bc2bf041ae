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

}  // namespace
}  // namespace lacuna
