// Coarser steps that only rank, and what an integration error could do to a candidate's evidence.
#include "diagnosis/judge.h"

#include <gtest/gtest.h>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

/// A pendulum with a concealed deadband, its plain model identified at `step`.
struct Concealed {
  explicit Concealed(double step)
      : scenario(pendulum_problem({2.2, 1.1, 5.0, 1.0}, {"gain", "damping", "stiffness"}, 1e-3,
                                  {effect("valve_deadband", "swing", {{"d", 0.5}})}, 10.0, available_engines().back())),
        model(scenario),
        experiment(make_experiment(scenario)),
        space(model, scenario),
        at(on("featherstone", step)),
        train(experiment.with_role(Role::train)) {
    FitResult fit;
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.simulator = at;
    options.step = step;
    current = identify_plain(model, experiment, space, options, fit);
  }
  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SearchSpace space;
  SimulatorOptions at;
  std::vector<int> train;
  std::optional<CurrentModel> current;
};

TEST(CoarseLook, LeavesThePresentModelsResidualAsItIs) {
  const Concealed c(0.005);
  const CoarseLook look = coarse_look(*c.current, c.experiment, c.at);
  EXPECT_EQ(look.simulator.max_step, 0.020) << "four times; also the sampling period";
  Problem problem(c.model, c.experiment, c.space, look.simulator, c.current->weights);
  const std::vector<std::vector<double>> present{c.space.expand(c.current->fit.point)};
  const Eigen::VectorXd same = look.residuals_of(problem, present, c.train).front();
  EXPECT_LT((same - c.current->fit.residual).norm(), 1e-12 * same.norm());
}

TEST(CoarseLook, ShowsWhatAnEffectChangesAsTheOwnStepDoes) {
  const Concealed c(0.005);
  const CoarseLook look = coarse_look(*c.current, c.experiment, c.at);
  const PlantModel with = c.model.with_effects({effect("valve_deadband", "swing", {})});
  std::vector<double> values = c.space.expand(c.current->fit.point);
  values.push_back(0.1);
  const std::vector<std::vector<double>> one{values};
  Problem fine(with, c.experiment, c.space, c.at, c.current->weights);
  Problem coarse(with, c.experiment, c.space, look.simulator, c.current->weights);
  const Eigen::VectorXd own = fine.residuals_of(one, c.train).front();
  const Eigen::VectorXd seen = look.residuals_of(coarse, one, c.train).front();
  EXPECT_LT((seen - own).norm(), 0.05 * (own - c.current->fit.residual).norm());
}

TEST(CoarseLook, KeepsTheOwnStepWhereAnythingLongerIsNone) {
  const Concealed c(0.020);
  const CoarseLook look = coarse_look(*c.current, c.experiment, c.at);
  EXPECT_EQ(look.simulator.max_step, 0.020);
  EXPECT_EQ(look.correction.squaredNorm(), 0.0);
}

TEST(Judge, SaysOfEveryCandidateWhyNotInNumbers) {
  const Concealed c(0.005);
  DecideOptions options;
  options.simulator = c.at;
  Judge judge(*c.current, c.experiment, options, 1);
  const auto anywhere = [](const std::string&) { return true; };
  int can = 0, candidates = 0;
  for (ScreenedEffect& effect : screen_effects(*c.current, c.experiment, {c.at, anywhere})) {
    const Tried tried = judge.weigh(std::move(effect));
    const std::string objection = judge.objection(tried);
    EXPECT_EQ(objection.find("nan"), std::string::npos) << tried.effect.spec.effect << ": " << objection;
    can += objection.empty();
    ++candidates;
  }
  EXPECT_GT(can, 0);
  EXPECT_LT(can, candidates);
}

TEST(Judge, DoubtCoversWhatAFinerStepChanges) {
  const Concealed c(0.020);
  DecideOptions options;
  options.simulator = c.at;
  Judge judge(*c.current, c.experiment, options, 1);
  const auto anywhere = [](const std::string&) { return true; };
  for (ScreenedEffect& effect : screen_effects(*c.current, c.experiment, {c.at, anywhere})) {
    if (effect.spec.effect != "valve_deadband" && effect.spec.effect != "coulomb_friction") continue;
    Tried tried = judge.weigh(std::move(effect));
    ASSERT_TRUE(judge.refit(tried));
    judge.set_step(0.020);
    const double before = tried.train.log_likelihood + tried.heldout.gain, doubt = judge.doubt(tried);
    EXPECT_GT(doubt, 0.0);
    judge.set_step(0.0025);
    judge.follow(tried);
    const double after = tried.train.log_likelihood + tried.heldout.gain;
    EXPECT_LT(std::fabs(after - before), doubt + 1.0) << "and one nat that a fit may leave";
    EXPECT_LT(judge.doubt(tried), 0.5 * doubt);
  }
}

}  // namespace
}  // namespace lacuna
