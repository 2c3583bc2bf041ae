#include "study/trial.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/study/problems.h"

namespace lacuna {
namespace {

using namespace test;

TEST(Trial, KeepsTheSearchAsTheScenarioOrdersIt) {
  const Trial trial = joint_2_trial();
  ASSERT_EQ(trial.box.names.size(), 9u);
  EXPECT_EQ(trial.box.names.front(), "joint_2.gain");
  EXPECT_EQ(trial.box.names[3], "link_1.mass");
  EXPECT_EQ(trial.axes[3].parameter, -1) << "link 1 does not move";
  EXPECT_EQ(trial.fixed.size(), 5u);
  EXPECT_EQ(trial.output_unit, "deg");
  ASSERT_TRUE(trial.truth);
  EXPECT_DOUBLE_EQ((*trial.truth)[2], 3060.0);
}

TEST(Trial, ErrorsVanishAtTheTruthButForTheNoise) {
  const Trial trial = joint_2_trial();
  const Task task = make_task(trial, "featherstone", nullptr);
  Problem problem(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  const AnswerErrors errors = errors_of(problem, task, *trial.truth);
  EXPECT_EQ(errors.parameter_index, 0.0);
  EXPECT_EQ(errors.combination_index, 0.0);
  constexpr double kNoise = 3e-4 * 180.0 / std::numbers::pi;  // deg, of the bundled recordings
  EXPECT_NEAR(errors.output_rms, kNoise, 0.1 * kNoise);
  EXPECT_LT(errors.output_largest, 6.0 * kNoise);
}

TEST(Trial, ACommonFactorChangesParametersButNoCombination) {
  const Trial trial = joint_2_trial();
  std::vector<double> doubled = *trial.truth;
  for (double& x : doubled) x *= 1.5;
  const Task task = make_task(trial, "featherstone", nullptr);
  Problem problem(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  const AnswerErrors at_truth = errors_of(problem, task, *trial.truth), errors = errors_of(problem, task, doubled);
  EXPECT_NEAR(errors.parameter_index, 9 * 50.0, 1e-6);
  EXPECT_LT(errors.combination_index, 1e-9);
  EXPECT_NEAR(errors.output_rms, at_truth.output_rms, 1e-6 * at_truth.output_rms);
}

TEST(Trial, CombinationsAreThoseOfAPendulumByHand) {
  const Trial trial = pendulum_trial();
  const std::vector<Combination> found = combinations(trial, *trial.truth);
  ASSERT_EQ(found.size(), 5u);
  const PendulumTruth truth;
  EXPECT_NEAR(found[0].value, truth.gain / truth.stiffness, 1e-12);
  EXPECT_NEAR(found[1].value, truth.damping / truth.stiffness, 1e-12);
  const Inertial rod = trial.model->inertials(trial.model->values()).front();
  const double inertia = rod.inertia(1, 1) + rod.mass * rod.com.squaredNorm();  // about the pivot, axis y
  EXPECT_NEAR(found[2].value, inertia / truth.stiffness, 1e-9);
  // It hangs or stands along z at 0: no moment there, all of it at a right angle.
  EXPECT_NEAR(found[3].value, 0.0, 1e-12);
  EXPECT_NEAR(std::fabs(found[4].value), rod.mass * 9.81 * rod.com.norm() / truth.stiffness, 1e-9);
}

TEST(Trial, RefusesATruthThatTheSearchCannotReach) {
  Scenario truth = swinging_truth();
  truth.actuators.front().parameters["gain"] = 1000.0;
  EXPECT_NE(input_error([&] { make_trial(swinging(), &truth); }).find("swing.gain outside the bounds"),
            std::string::npos);
}

TEST(Trial, OtherBoundsAreThoseOfTheTask) {
  const Trial trial = joint_2_trial();
  Box box = trial.box;
  box.upper[0] = 150.0;
  const Task task = make_task(trial, trial.experiment, box, "featherstone", nullptr);
  EXPECT_EQ(task.space.axes().front().upper, 150.0);
  EXPECT_EQ(task.space.size(), 8u);
  const std::vector<double> inner = inner_point(task, *trial.truth);
  EXPECT_EQ(inner.size(), 8u);
  EXPECT_EQ(outer_point(task, inner, *trial.truth), *trial.truth);
}

TEST(Trial, TruthIsFoundBesideTheTrainRecording) {
  EXPECT_EQ(find_truth(bundled("joint_2_table5.yaml"))->parent_path().filename(), "joint_2_table5");
  EXPECT_FALSE(find_truth(swinging()));
}

}  // namespace
}  // namespace lacuna
