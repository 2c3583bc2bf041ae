// The motion proposed to separate a class gives the evidence that it promises.
#include "diagnosis/separate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/baseline.h"
#include "ga/random.h"
#include "physics/course.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kReadingNoise = 1e-3, kDelay = 0.01, kStep = 0.005;  // rad, s, s
const std::vector<std::string> kFree{"gain", "damping", "stiffness"};

/// A delay on slow sines, found with a lag as its rival.
struct Merged {
  Merged()
      : scenario(pendulum_problem({2.2, 1.1, 5.0, 1.0}, kFree, kReadingNoise,
                                  {effect("input_delay", "swing", {{"T", kDelay}})}, 8.0, engine_of_data())),
        model(scenario),
        experiment(make_experiment(scenario)),
        space(model, scenario) {
    IdentifyOptions options;
    options.optimizer = Optimizer::lsq;
    options.step = kStep;
    FitResult fit;
    plain = identify_plain(model, experiment, space, options, fit);
    current = extended(*plain, experiment, {"input_delay", "swing", {}, {}, "test"}, plain->fit.point, {kDelay});
    refine(*current, {experiment, on("featherstone", kStep)}, 25);
    findings.resize(1);
    Finding& f = findings.front();
    f.effect = "input_delay";
    f.place = "swing";
    f.members = {"input_delay", "actuator_lag"};
    f.rivals = {{"actuator_lag", "swing", 0.3, {}, {kDelay}}, {"backlash", "swing", 0.1, {}, {}}};
  }
  void look() { separate(findings, *plain, *current, {experiment, on("featherstone", kStep)}, 5); }

  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SearchSpace space;
  std::optional<CurrentModel> plain, current;
  std::vector<Finding> findings;
};

/// Squares over noise that are left of the train segments, re-identified.
double energy_left(CurrentModel model, const Experiment& experiment) {
  Problem problem(model.model, experiment, model.space, on("featherstone", kStep), {kReadingNoise});
  LeastSquaresOptions options;
  options.polish = false;
  return solve_least_squares(problem, model.fit.point, experiment.with_role(Role::train), options).sum_of_squares;
}

TEST(Separate, ProposesAMotionThatGivesTheEvidenceItPromises) {
  Merged merged;
  merged.look();
  ASSERT_TRUE(merged.findings[0].separation);
  const Separation& s = *merged.findings[0].separation;
  EXPECT_EQ(s.rival, "actuator_lag");
  EXPECT_GT(s.evidence, 5.0);
  EXPECT_GT(s.evidence, s.recorded) << "better than one more recording like the others";

  // The motion recorded: what the found model does, with noise.
  const CurrentModel& found = *merged.current;
  Experiment more = merged.experiment;
  const Segment& first = more.segments[more.with_role(Role::train).front()];
  Experiment moved = commanded(more, s.commands, first.q0);
  const PlantModel& model = found.model;
  const std::vector<std::vector<double>> values{found.space.expand(found.fit.point)};
  Segment& segment = moved.segments.front();
  make_simulator(model, moved, on("featherstone", kStep))
      ->run(values, std::vector<int>{0},
            [&](int, int, const auto& predicted) { segment.measured.assign(predicted.begin(), predicted.end()); });
  const SeenMotion seen =
      seen_motion(moved, segment, segment.measured, recorded_limits(model.robot(), merged.experiment));
  EXPECT_EQ(seen.beyond, 0.0) << "within the limits of the recordings";
  RandomStream noise(17, 0, 0);
  for (double& q : segment.measured[0]) q += kReadingNoise * noise.normal();
  more.segments.push_back(segment);

  CurrentModel rival = extended(*merged.plain, merged.experiment, {"actuator_lag", "swing", {}, {}, "test"},
                                merged.plain->fit.point, {kDelay});
  const double recorded = energy_left(rival, merged.experiment) - energy_left(found, merged.experiment);
  const double seen_evidence = 0.5 * (energy_left(rival, more) - energy_left(found, more) - recorded);
  // Its variance is twice its mean; the linearisation of the rival is good to a fifth.
  EXPECT_NEAR(seen_evidence, s.evidence, 3.0 * std::sqrt(2.0 * s.evidence) + 0.2 * s.evidence);
}

TEST(Separate, LeavesAloneWhatIsNotMerged) {
  Merged merged;
  merged.findings[0].members = {"input_delay"};
  merged.look();
  EXPECT_FALSE(merged.findings[0].separation);
}

TEST(Separate, AMemberThatIsAFindingOfItsOwnIsNoRivalAnyMore) {
  Merged merged;
  Finding lag;
  lag.effect = "actuator_lag", lag.place = "swing";
  lag.members = {"actuator_lag"};
  merged.findings.push_back(lag);
  merged.current = extended(*merged.current, merged.experiment, {"actuator_lag", "swing", {}, {}, "test"},
                            merged.current->fit.point, {kDelay});
  ASSERT_NO_THROW(merged.look());
  EXPECT_FALSE(merged.findings[0].separation) << "no other member is left to be told from";
}

TEST(Separate, SameSeedSameMotionOnAnyNumberOfThreads) {
  Merged one, two;
  one.look();
  SimulatorOptions threads = on("featherstone", kStep);
  threads.threads = 3;
  separate(two.findings, *two.plain, *two.current, {two.experiment, threads}, 5);
  EXPECT_TRUE(same_bits(one.findings[0].separation->commands.value, two.findings[0].separation->commands.value));
  EXPECT_EQ(one.findings[0].separation->evidence, two.findings[0].separation->evidence);
}

}  // namespace
}  // namespace lacuna
