#include "study/identifiability.h"

#include <gtest/gtest.h>

#include "physics/course.h"
#include "tests/study/problems.h"

namespace lacuna {
namespace {

using namespace test;

Excitation of(const std::vector<Excitation>& all, const std::string& name, const std::string& assumption) {
  for (const Excitation& e : all) {
    if (e.name == name && e.assumption == assumption) return e;
  }
  throw std::logic_error(name);
}

TEST(Identifiability, AnglesOfJointTwoFixFourDirectionsOfNine) {
  const std::vector<Excitation> all = assess_all(joint_2_trial());
  const Excitation train = of(all, "joint_2_table1/train.csv", "");
  EXPECT_EQ(train.parameters, 9);
  // gain, damping, inertia and weight over stiffness; the centres of mass lie so near the links' axis that the weight's
  // second component is known to a quarter at best.
  EXPECT_EQ(train.rank, 4);
  ASSERT_EQ(train.combinations.size(), 5u);
  EXPECT_FALSE(train.knowledge[3].moves) << "link 1";
  EXPECT_TRUE(std::isinf(train.condition));
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT(train.combination_error[k], 0.01) << train.combinations[k].name;
  EXPECT_GT(train.combination_error[4], 0.1);
  EXPECT_FALSE(train.undetermined.empty());
}

TEST(Identifiability, AKnownTotalMassTellsNothingWhileLinkOneMayTakeItAll) {
  const std::vector<Excitation> all = assess_all(joint_2_trial());
  const Excitation with = of(all, "joint_2_table1/train.csv", "total mass known");
  const Excitation without = of(all, "joint_2_table1/train.csv", "");
  // One more direction (the total itself), yet nothing of gain, damping and stiffness.
  EXPECT_EQ(with.rank, without.rank + 1);
  EXPECT_GT(with.knowledge[0].relative_error, 1.0);
}

TEST(Identifiability, ExpectedErrorsAreTheScatterOfEstimates) {
  // A pendulum whose mass is known: nothing is open. Errors from sensitivities against refits of fresh noise.
  const Trial trial = pendulum_trial();
  const Task task = make_task(trial, "featherstone", nullptr);
  const Excitation expected = assess(task, *trial.truth, "train", false);
  EXPECT_EQ(expected.rank, 3);
  constexpr int kRepeats = 40;
  std::vector<double> square(3, 0.0);
  Noise noise(5);
  Problem at_truth(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  const Eigen::VectorXd residual = at_truth.residual(inner_point(task, *trial.truth), task.train);
  for (int k = 0; k < kRepeats; ++k) {
    Task again = task;
    Eigen::Index row = 0;
    for (const int s : task.train) {
      Segment& segment = again.experiment.segments[s];
      for (double& x : segment.measured[0]) x += task.weights[0] * (residual(row++) + noise());
    }
    Problem problem(*trial.model, again.experiment, again.space, again.simulator, again.weights);
    const auto found = solve_least_squares(problem, *trial.truth, again.train);
    for (std::size_t i = 0; i < 3; ++i) square[i] += std::pow(found.point[i] / (*trial.truth)[i] - 1.0, 2);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double scatter = std::sqrt(square[i] / kRepeats);
    // The deviation of a deviation from 40 draws is 11 %; three of it.
    EXPECT_NEAR(scatter / expected.knowledge[i].relative_error, 1.0, 0.34) << expected.knowledge[i].name;
  }
}

TEST(Identifiability, EllipsesAreCentredAndAsWideAsTheErrorsSay) {
  const Trial trial = pendulum_trial();
  const Excitation e = assess(make_task(trial, "featherstone", nullptr), *trial.truth, "train", false);
  const Ellipse& l = e.ellipses.back();
  EXPECT_EQ(l.x_name, "swing.gain");
  const auto [low, high] = std::minmax_element(l.boundary_x.begin(), l.boundary_x.end());
  const double deviation = e.knowledge[0].relative_error * e.knowledge[0].value;
  EXPECT_NEAR(0.5 * (*high - *low), std::sqrt(5.991464547) * deviation, 0.01 * deviation);
  EXPECT_NEAR(0.5 * (*high + *low), l.x, 0.01 * deviation);
}

TEST(Identifiability, RestIsWhereTheSpringCarriesTheWeight) {
  const Trial trial = joint_2_trial();
  const std::vector<double> rest = rest_position(trial, model_values(trial, *trial.truth));
  const std::vector<Combination> c = combinations(trial, *trial.truth);
  // stiffness (q - 0.4) = -weight(q), the weight's moment turning with cos and sin of q.
  const double weight = c[3].value * std::cos(rest[0]) + c[4].value * std::sin(rest[0]);
  EXPECT_NEAR(rest[0] - 0.4, -weight, 1e-6);
}

TEST(Identifiability, StepsStartAfterAHalfSecondOfRest) {
  const Trial trial = pendulum_trial();
  const CommandTrack step = step_commands(trial, std::vector<double>{2.0}, 3.0);
  EXPECT_EQ(step.value[0][24], 0.0);
  EXPECT_EQ(step.value[0].back(), 2.0);
  EXPECT_NEAR(step.time.back(), 3.0, 1e-9);
  const Experiment experiment = commanded(trial.experiment, step, std::vector<double>{0.25});
  ASSERT_EQ(experiment.segments.size(), 1u);
  EXPECT_EQ(experiment.segments[0].q0[0], 0.25);
  EXPECT_EQ(experiment.segments[0].measured[0].size(), step.time.size());
}

}  // namespace
}  // namespace lacuna
