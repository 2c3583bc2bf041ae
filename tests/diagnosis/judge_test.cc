// Coarser steps that only rank, and what an integration error could do to a candidate's evidence.
#include "diagnosis/judge.h"

#include <gtest/gtest.h>

#include "diagnosis/baseline.h"
#include "diagnosis/coarse.h"
#include "diagnosis/ranking.h"
#include "diagnosis/worth.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kReading = 1e-3;  // rad, noise of a reading

/// A pendulum with a deadband.
Scenario one_joint() {
  return pendulum_problem({2.2, 1.1, 5.0, 1.0}, {"gain", "damping", "stiffness"}, kReading,
                          {effect("valve_deadband", "swing", {{"d", 0.5}})}, 10.0, engine_of_data());
}

/// Two joints that miss something each: a deadband of .5 V at the upper, one of `lower` (V) at the lower.
Scenario two_joints(double lower) {
  const Scenario plain =
      bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                    {actuator("shoulder", "torque_source", {{"gain", 6.0}, {"damping", 2.0}, {"stiffness", 5.0}}),
                     actuator("elbow", "torque_source", {{"gain", 2.0}, {"damping", 0.5}, {"stiffness", 2.0}})},
                    false);
  Scenario truth = plain, scenario = plain;
  truth.effects = {effect("valve_deadband", "shoulder", {{"d", 0.5}}),
                   effect("valve_deadband", "elbow", {{"d", lower}})};
  double shift = 0.0;
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    Drive drive = sine_drive(2, 10.0, 0.02, 3.0, shift += 7.3);
    for (std::vector<double>& u : drive.u) std::fill_n(u.begin(), 25, 0.0);
    add_recording(
        scenario,
        simulated_recording(truth, drive, {{0.0, 0.0}, {0.0, 0.0}, false}, engine_of_data(),
                            std::string(to_string(role)) + ".csv", kReading, static_cast<std::uint64_t>(shift)),
        role);
  }
  for (const std::string joint : {"shoulder", "elbow"}) {
    for (const char* name : {".gain", ".damping", ".stiffness"})
      scenario.identify.push_back({joint + name, true, 0.2, 5.0, "test: identify." + joint + name});
    scenario.noise[ChannelKind::position][joint] = kReading;
  }
  return scenario;
}

/// A scenario, its plain model identified at `step`.
struct Concealed {
  explicit Concealed(double step, Scenario of = one_joint())
      : scenario(std::move(of)),
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
  FitContext context() const { return {experiment, at}; }
  Judge judge() const { return {*current, context(), 1}; }
  std::vector<ScreenedEffect> screened() const {
    return screen_effects(*current, context(), {[](const std::string&) { return true; }});
  }
  /// The plain model with an effect beside it, fitted.
  CurrentModel with(const std::string& name, double start) const {
    CurrentModel out = extended(*current, experiment, {name, "swing", {}, {}, "test"}, current->fit.point, {start});
    EXPECT_TRUE(refit(out, context()));
    return out;
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
  const CoarseLook look = coarse_look(*c.current, c.context());
  EXPECT_EQ(look.context.simulator.max_step, 0.020) << "four times; also the sampling period";
  Problem problem(c.model, c.experiment, c.space, look.context.simulator, c.current->weights);
  const std::vector<std::vector<double>> present{c.space.expand(c.current->fit.point)};
  const Eigen::VectorXd same = look.residuals_of(problem, present, c.train).front();
  EXPECT_LT((same - c.current->fit.residual).norm(), 1e-12 * same.norm());
}

TEST(CoarseLook, ShowsWhatAnEffectChangesAsTheOwnStepDoes) {
  const Concealed c(0.005);
  const CoarseLook look = coarse_look(*c.current, c.context());
  const PlantModel with = c.model.with_effects({effect("valve_deadband", "swing", {})});
  std::vector<double> values = c.space.expand(c.current->fit.point);
  values.push_back(0.1);
  const std::vector<std::vector<double>> one{values};
  Problem fine(with, c.experiment, c.space, c.at, c.current->weights);
  Problem coarse(with, c.experiment, c.space, look.context.simulator, c.current->weights);
  const Eigen::VectorXd own = fine.residuals_of(one, c.train).front();
  const Eigen::VectorXd seen = look.residuals_of(coarse, one, c.train).front();
  EXPECT_LT((seen - own).norm(), 0.05 * (own - c.current->fit.residual).norm());
}

TEST(CoarseLook, KeepsTheOwnStepWhereAnythingLongerIsNone) {
  const Concealed c(0.020);
  const CoarseLook look = coarse_look(*c.current, c.context());
  EXPECT_EQ(look.context.simulator.max_step, 0.020);
  EXPECT_EQ(look.correction.squaredNorm(), 0.0);
}

TEST(CoarseLook, AStepMattersByWhatItChangesOfTheRest) {
  const Concealed c(0.0025);
  for (const double step : {0.005, 0.010, 0.020}) {
    Problem problem = problem_of(*c.current, c.context().with_step(step));
    const Eigen::VectorXd& rest = c.current->fit.residual;
    const double change = (problem.residual(c.current->fit.point, c.train) - rest).squaredNorm() / rest.squaredNorm();
    EXPECT_EQ(step_matters(*c.current, c.context(), step), change > 0.01) << step << ": " << change;
  }
  const double chosen = coarse_enough(*c.current, c.context());
  EXPECT_GE(chosen, c.at.max_step);
  EXPECT_FALSE(chosen > c.at.max_step && step_matters(*c.current, c.context(), chosen));
  EXPECT_TRUE(2.0 * chosen > c.experiment.sample_period || step_matters(*c.current, c.context(), 2.0 * chosen));
}

TEST(Judge, SaysOfEveryCandidateWhyNotInNumbers) {
  const Concealed c(0.005);
  Judge judge = c.judge();
  int can = 0, candidates = 0;
  for (ScreenedEffect& effect : c.screened()) {
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
  Judge judge = c.judge();
  for (ScreenedEffect& effect : c.screened()) {
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

TEST(Judge, AsksForAShareOfWhatTheJointMissesNotOfWhatTheMachineDoes) {
  for (const auto& [deadband, enough] : {std::pair{0.15, true}, {0.1, false}}) {
    const Concealed c(0.005, two_joints(deadband));
    Judge judge = c.judge();
    int lower = 0;
    for (ScreenedEffect& effect : c.screened()) {
      if (effect.spec.effect != "valve_deadband" || effect.spec.place != "elbow") continue;
      Tried tried = judge.weigh(std::move(effect));
      ASSERT_TRUE(judge.refit(tried));
      EXPECT_LT(tried.heldout.share, 0.25) << "of what both joints miss";
      const std::string objection = judge.objection(tried);
      EXPECT_EQ(objection.empty(), enough) << deadband << ": " << objection;
      EXPECT_EQ(objection.find("where it removes most") != std::string::npos, !enough) << objection;
      ++lower;
    }
    EXPECT_EQ(lower, 1);
  }
}

TEST(Judge, CannotTellASpecialCaseFromWhatPredictsAlike) {
  const Concealed c(0.005);
  const Judge judge = c.judge();
  const auto tried = [&](const char* name, int parameters, double share) {
    Tried out{{}, *c.current, {}, {}};
    out.effect.spec.effect = name, out.effect.spec.place = "swing";
    out.effect.parameters = parameters;
    out.heldout.share = share;
    return out;
  };
  const Tried coulomb = tried("coulomb_friction", 1, 0.5), stribeck = tried("stribeck_friction", 3, 0.5 + 1e-9);
  EXPECT_TRUE(judge.cannot_tell(coulomb, stribeck));
  EXPECT_FALSE(judge.cannot_tell(stribeck, coulomb)) << "the one with fewer numbers is the special case";
  EXPECT_FALSE(judge.cannot_tell(coulomb, tried("stribeck_friction", 3, 0.9))) << "the deadband is far over the noise";
  EXPECT_FALSE(judge.cannot_tell(coulomb, tried("valve_offset", 3, 0.5))) << "no kin";
  Tried elsewhere = stribeck;
  elsewhere.effect.spec.place = "arm";
  EXPECT_FALSE(judge.cannot_tell(coulomb, elsewhere));
}

TEST(Judge, ACandidateThatIsReidentifiedLateIsRankedByWhatItIsWorthThen) {
  // Either of two joints' deadbands can be what is missing.
  const Concealed c(0.005, two_joints(0.5));
  Judge judge = c.judge();
  std::vector<Tried> ends, starts;
  for (ScreenedEffect& effect : c.screened()) {
    if (effect.spec.effect != "valve_deadband") continue;
    starts.push_back(judge.weigh(std::move(effect)));
    ends.push_back(starts.back());
    ASSERT_TRUE(judge.refit(ends.back()));
    ASSERT_EQ(judge.objection(ends.back()), "");
  }
  ASSERT_EQ(ends.size(), 2u);
  sort_by_evidence(ends, 0.0);
  const Tried& best = ends.front();
  // As if screening had promised of the other what no fit keeps.
  Tried promised = starts[starts[0].effect.spec.place == best.effect.spec.place ? 1 : 0];
  promised.train.log_likelihood *= 100.0;
  for (Gain::Channel& channel : promised.train.channels) channel.log_ratio *= 100.0;
  std::vector<Tried> tried{best, promised};
  sort_by_evidence(tried, 0.0);
  ASSERT_FALSE(tried.front().refitted);
  const std::optional<std::size_t> found = strongest_that_can(judge, tried, 0.0);
  ASSERT_EQ(found, std::optional<std::size_t>(0));
  EXPECT_EQ(tried[0].effect.spec.place, best.effect.spec.place);
  EXPECT_TRUE(tried[1].refitted);
}

TEST(Worth, OfAPartThatIsThereAndOfOneThatIsNot) {
  const Concealed c(0.005);
  const CurrentModel right = c.with("valve_deadband", 0.3);
  const Worth worth = worth_over(right, *c.current, c.context());
  EXPECT_EQ(worth.parameters, 1);
  ASSERT_TRUE(worth.heldout);
  EXPECT_GT(worth.heldout->share, 0.9);
  EXPECT_EQ(worth.gain(), worth.train.log_likelihood + worth.heldout->gain);
  EXPECT_LT(worth.chance(100), 1e-6);

  // Beside the deadband nothing else is needed.
  CurrentModel more =
      extended(right, c.experiment, {"quadratic_damping", "swing", {}, {}, "test"}, right.fit.point, {0.01});
  ASSERT_TRUE(refit(more, c.context()));
  const Worth nothing = worth_over(more, right, c.context());
  EXPECT_EQ(nothing.parameters, 1);
  EXPECT_GT(nothing.chance(1), kChance);
  EXPECT_EQ(nothing.chance(1000), 1.0);
}

}  // namespace
}  // namespace lacuna
