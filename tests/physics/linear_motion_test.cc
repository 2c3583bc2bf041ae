// The plant linearised along its motion against simulations of the same small causes, on every engine.
#include "physics/linear_motion.h"

#include <gtest/gtest.h>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kSmall = 1e-3;  // N m, of efforts of the order of one: the response is linear to that share

/// A driven double pendulum with an offset at its second joint, which is nothing at first.
struct Driven {
  explicit Driven(std::vector<EffectSpec> others = {}, const std::string& actuators = "torque_source") {
    auto parameters = std::map<std::string, double>{{"gain", 2.0}, {"damping", 0.6}, {"stiffness", 8.0}};
    scenario = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {}, sine_drive(2, 3.0, 0.02, 2.0),
                               at_rest);
    for (const Joint& joint : scenario.robot->joints())
      scenario.actuators.push_back(actuator(joint.name, actuators, parameters));
    scenario.effects = std::move(others);
    scenario.effects.push_back(effect("torque_offset", scenario.robot->joints()[1].name, {{"tau0", 0.0}}));
    model.emplace(scenario);
    experiment = started_experiment(scenario, at_rest);
    with = model->values();
    with[model->find(scenario.robot->joints()[1].name + ".torque_offset.tau0")] = kSmall;
  }
  /// Of the offset: channel by channel.
  std::vector<std::vector<double>> simulated_change(const std::string& engine) const {
    const Predictions all = predict(*model, experiment, {model->values(), with}, on(engine, 0.01));
    std::vector<std::vector<double>> out = all[1][0];
    for (std::size_t c = 0; c < out.size(); ++c)
      for (std::size_t k = 0; k < out[c].size(); ++k) out[c][k] -= all[0][0][c][k];
    return out;
  }

  Start at_rest{{0.4, -0.3}, {0.0, 0.0}};
  Scenario scenario;
  std::optional<PlantModel> model;
  Experiment experiment;
  std::vector<double> with;
};

double rms(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

/// What the linearised plant makes of the efforts that `with` adds along the motion, against its simulation.
void expect_linear_response(const Driven& driven, const std::string& engine, double share) {
  const std::vector<int> one{0};
  const auto simulator = make_simulator(*driven.model, driven.experiment, on(engine, 0.01));
  const std::vector<LinearMotion> motion = simulator->linearise(driven.model->values(), one, {1.0, 1.0});
  ASSERT_TRUE(motion.front().is_finite());
  const std::vector<std::vector<double>> values{driven.model->values(), driven.with};
  std::vector<std::vector<std::vector<double>>> excess(2);
  simulator->excess(values, one, motion, [&](int i, int, const auto& efforts) { excess[i] = efforts; });
  const auto intervals = static_cast<Eigen::Index>(motion.front().intervals());
  Eigen::MatrixXd added(2, intervals);
  for (Eigen::Index j = 0; j < 2; ++j)
    for (Eigen::Index k = 0; k < intervals; ++k) added(j, k) = excess[1][j][k] - excess[0][j][k];
  const Eigen::MatrixXd response = motion.front().response(added);
  const std::vector<std::vector<double>> wanted = driven.simulated_change(engine);
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<double> miss = wanted[c];
    for (std::size_t k = 0; k < miss.size(); ++k) miss[k] -= response(c, k);
    EXPECT_LT(rms(miss), share * rms(wanted[c])) << "channel " << c;
    EXPECT_GT(rms(wanted[c]), 0.0);
  }
}

class LinearMotionOn : public testing::TestWithParam<std::string> {};

TEST_P(LinearMotionOn, RespondsAsTheSimulationDoes) { expect_linear_response(Driven(), GetParam(), 1e-3); }

TEST_P(LinearMotionOn, NeedsNoEffortBeyondItsOwn) {
  const Driven driven;
  const std::vector<int> one{0};
  const auto simulator = make_simulator(*driven.model, driven.experiment, on(GetParam(), 0.01));
  const std::vector<LinearMotion> motion = simulator->linearise(driven.model->values(), one, {1.0, 1.0});
  const std::vector<std::vector<double>> values{driven.model->values()};
  simulator->excess(values, one, motion, [](int, int, const auto& efforts) {
    // What is left is that an interval's mean is not its middle: of second order in the sampling period.
    for (const std::vector<double>& joint : efforts) EXPECT_LT(rms(joint), 0.02);
  });
}

INSTANTIATE_TEST_SUITE_P(Engines, LinearMotionOn, testing::ValuesIn(available_engines()),
                         [](const auto& engine) { return engine.param; });

TEST(LinearMotion, CarriesTheStatesOfAnActuator) {
  expect_linear_response(Driven({}, "flow_source"), "featherstone", 1e-2);
}

TEST(LinearMotion, IsThatOfAPlantWithFriction) {
  const std::string joint = Driven().scenario.robot->joints()[0].name;
  expect_linear_response(Driven({effect("coulomb_friction", joint, {{"Fc", 0.2}})}), "featherstone", 0.1);
}

TEST(LinearMotion, AnswersNothingToNothing) {
  const Driven driven;
  const std::vector<int> one{0};
  const auto motion = make_simulator(*driven.model, driven.experiment, on("featherstone", 0.01))
                          ->linearise(driven.model->values(), one, {1.0, 1.0});
  const auto intervals = static_cast<Eigen::Index>(motion.front().intervals());
  EXPECT_EQ(motion.front().response(Eigen::MatrixXd::Zero(2, intervals)).norm(), 0.0);
}

TEST(LinearMotion, AnswersManyEffortsAtOneJointAsEachAlone) {
  constexpr double kRoundingOfAProduct = 1e-13;  // of forty products, each smaller than what went in
  constexpr Eigen::Index kStates = 5, kIntervals = 40, kRows = 3;
  Noise random(4);
  const auto drawn = [&](Eigen::Index rows, Eigen::Index columns, double size) {
    Eigen::MatrixXd out(rows, columns);
    for (Eigen::Index j = 0; j < columns; ++j)
      for (Eigen::Index i = 0; i < rows; ++i) out(i, j) = size * random();
    return out;
  };
  LinearMotion motion;
  motion.dof = 2;
  for (Eigen::Index k = 0; k < kIntervals; ++k) {
    motion.A.push_back(drawn(kStates, kStates, 0.3));
    motion.B.push_back(drawn(kStates, 2, 1.0));
  }
  const Eigen::MatrixXd efforts = drawn(kRows, kIntervals, 1.0);
  for (const int joint : {0, 1}) {
    const std::vector<Eigen::MatrixXd> found = motion.responses_at(joint, efforts);
    ASSERT_EQ(found.size(), 3u);
    for (Eigen::Index i = 0; i < kRows; ++i) {
      Eigen::MatrixXd alone = Eigen::MatrixXd::Zero(2, kIntervals);
      alone.row(joint) = efforts.row(i);
      const Eigen::MatrixXd expected = motion.response(alone);
      ASSERT_EQ(found[i].cols(), kIntervals + 1);
      EXPECT_LT((found[i] - expected).norm(), kRoundingOfAProduct * expected.norm())
          << "joint " << joint << " row " << i;
      EXPECT_GT(expected.norm(), 1.0) << "nothing was tested";
    }
  }
}

}  // namespace
}  // namespace lacuna
