// The truth's integrator against the rollout's: two ways through time, one plant.
#include "physics/truth.h"

#include <gtest/gtest.h>

#include "ga/search_space.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kFineStep = 2.5e-4;  // s, of the rollout
// rad. Kinks (dead zones, stops, bristles) cost the rollout its order; what is left at this step lies far below any
// noise.
constexpr double kEngineAgreement = 1e-5;

TruthOptions on_featherstone() {
  TruthOptions options;
  options.engine = "featherstone";
  return options;
}

Scenario two_rods() {
  const std::map<std::string, double> p{{"gain", 4.0}, {"damping", 1.0}, {"stiffness", 8.0}, {"rest", 0.2}};
  return driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                         {actuator("shoulder", "torque_source", p), actuator("elbow", "torque_source", p)},
                         sine_drive(2, 3.0, 0.02, 2.0), {{0.1, 0.1}, {0.0, 0.0}, false});
}

/// The scenario with one effect of typical size; what typical means needs motion, so sizes are those of a moved plant.
PlantModel with_typical(const Scenario& scenario, const EffectInfo& info, const Experiment& moved) {
  const bool arm = info.where == Where::arm;
  EffectSpec spec = effect(info.name, arm ? "arm" : "shoulder", {});
  const PlantModel plain(scenario);
  for (const EffectParameter& p : effect_parameters(info, plain.robot(), arm ? -1 : 0)) {
    if (p.info->optional || p.info->starts.empty()) continue;
    const double size = typical_size(p.info->scale, plain, moved, p.joint, plain.values());
    spec.parameters[p.key] = typical_origin(p.info->scale, moved, p.joint) + p.info->starts.front() * size;
  }
  return plain.with_effects({spec});
}

/// The truth's motion, from whose start the experiment's simulations begin then.
std::vector<std::vector<double>> started_by_the_truth(const PlantModel& model, Experiment& experiment,
                                                      const std::string& engine) {
  TruthOptions options;
  options.engine = engine;
  auto truth = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  for (std::size_t j = 0; j < truth.size(); ++j) experiment.segments[0].q0[j] = truth[j][0];
  experiment.segments[0].v0.assign(truth.size(), 0.0);
  return truth;
}

double disagreement(const PlantModel& model, Experiment experiment, const std::string& engine) {
  const auto truth = started_by_the_truth(model, experiment, engine);
  const auto rollout = predict_one(model, experiment, on("featherstone", kFineStep)).front();
  double worst = 0.0;
  for (std::size_t c = 0; c < truth.size(); ++c) worst = std::max(worst, worst_difference(truth[c], rollout[c]));
  return worst;
}

Experiment moved_by_the_truth(const Scenario& scenario) {
  const PlantModel plain(scenario);
  Experiment experiment = make_experiment(scenario);
  const auto truth =
      simulate_truth(plain, experiment.segments[0], experiment.channels, plain.values(), on_featherstone());
  Scenario moved = scenario;
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (std::size_t j = 0; j < truth.size(); ++j)
    data->columns[static_cast<std::size_t>(data->find("q_" + scenario.robot->joints()[j].name))] = truth[j];
  moved.recordings[0].data = data;
  return make_experiment(moved);
}

TEST(Truth, AgreesWithTheRolloutForEveryEffect) {
  const Scenario scenario = two_rods();
  const Experiment moved = moved_by_the_truth(scenario);
  for (const EffectInfo& info : effect_table())
    EXPECT_LT(disagreement(with_typical(scenario, info, moved), moved, "featherstone"), kEngineAgreement) << info.name;
}

TEST(Lanes, EqualDoubleForEveryEffect) {
  // rad: roundings of either path, which events (a joint that sticks a step earlier) may carry on.
  constexpr double kRounding = 1e-9;
  const Scenario scenario = two_rods();
  const Experiment moved = moved_by_the_truth(scenario);
  for (const EffectInfo& info : effect_table()) {
    const PlantModel model = with_typical(scenario, info, moved);
    Noise random(11);
    std::vector<std::vector<double>> values(static_cast<std::size_t>(lane_info().width) + 1, model.values());
    for (std::vector<double>& individual : values) {
      for (double& x : individual) {
        if (std::isfinite(x)) x *= 0.9 + 0.2 * random.uniform();
      }
    }
    const auto lanes = predict(model, moved, values, on("featherstone", 0.005));
    auto scalar = make_engine_predictor("featherstone", model, moved);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::vector<LaneTask> one{{&values[i], &moved.segments[0]}};
      std::vector<std::vector<std::vector<double>>> expected;
      scalar->predict(one, 0.005, expected);
      for (std::size_t c = 0; c < moved.channels.size(); ++c)
        EXPECT_LT(worst_difference(lanes[i][0][c], expected[0][c]), kRounding) << info.name << ", individual " << i;
    }
  }
}

TEST(Truth, IsMetThroughStiffSpringsByTheStepThatIsChosen) {
  // rad. A step is to leave a tenth of it; where contacts cost the rollout its order, halving shows half of the error.
  constexpr double kNoise = 1e-4;
  Scenario scenario = two_rods();
  for (const Joint& joint : scenario.robot->joints()) scenario.noise[ChannelKind::position][joint.name] = kNoise;
  for (const EffectSpec& spec : {effect("joint_compliance", "elbow", {{"k", 1300.0}, {"J", 0.003}}),
                                 effect("backlash", "elbow", {{"gap", 1e-3}, {"k", 5000.0}, {"J", 0.01}}),
                                 effect("backlash", "elbow", {{"gap", 1e-3}, {"k", 5000.0}, {"J", 0.01}, {"c", 1.0}}),
                                 effect("base_compliance", "arm", {{"k", 2e4}})}) {
    const PlantModel model = PlantModel(scenario).with_effects({spec});
    Experiment experiment = moved_by_the_truth(scenario);
    const auto truth = started_by_the_truth(model, experiment, "featherstone");
    const StepChoice choice = choose_step(model, experiment, on("featherstone", 0.01), model.values());
    const auto rollout = predict_one(model, experiment, on("featherstone", choice.step)).front();
    for (std::size_t c = 0; c < truth.size(); ++c) {
      double sum = 0.0;
      for (std::size_t k = 0; k < truth[c].size(); ++k) sum += std::pow(rollout[c][k] - truth[c][k], 2);
      EXPECT_LT(std::sqrt(sum / static_cast<double>(truth[c].size())), 0.2 * kNoise)
          << spec.effect << " at steps of " << choice.step << " s";
    }
  }
}

TEST(Truth, EnginesAgreeThroughFriction) {
  Scenario scenario = two_rods();
  scenario.effects.push_back(effect("coulomb_friction", "elbow", {{"Fc", 0.8}}));
  const PlantModel model(scenario);
  // ODE's accelerations are derived from a tiny step.
  for (const std::string& engine : available_engines())
    EXPECT_LT(disagreement(model, make_experiment(scenario), engine), engine == "ode" ? 1e-4 : kEngineAgreement)
        << engine;
}

TEST(Truth, StartsAtRestWhereThePlantRests) {
  const Scenario scenario = driven_scenario(
      bundled_robot("pendulum/pendulum.urdf"),
      {actuator("swing", "torque_source", {{"gain", 1.0}, {"damping", 0.2}, {"stiffness", 6.0}, {"rest", 0.5}})},
      constant_drive(1, 1.0, 0.01, 0.3), {{0.0}, {0.0}, false});
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const auto truth =
      simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), on_featherstone());
  const double q = truth[0].front();
  EXPECT_NEAR(0.3 - 6.0 * (q - 0.5) - 9.81 * 0.5 * std::sin(q), 0.0, 1e-7);
  for (const double later : truth[0]) EXPECT_NEAR(later, q, 1e-8);
}

TEST(Truth, PhysicsOutsideTheCatalogueActs) {
  const Scenario scenario = two_rods();
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const auto run = [&](std::vector<OutsidePhysics> outside) {
    TruthOptions options = on_featherstone();
    options.outside = std::move(outside);
    return simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  };
  const auto plain = run({});
  using Kind = OutsidePhysics::Kind;
  EXPECT_GT(worst_difference(run({{Kind::position_ripple, 0, 0.5, {}}})[0], plain[0]), 1e-3);
  for (const Kind kind : {Kind::external_push, Kind::command_dropout}) {
    const auto other = run({{kind, 0, 0.5, {{1.0}}}});
    EXPECT_GT(worst_difference(other[0], plain[0]), 1e-3) << to_string(kind);
    for (std::size_t k = 0; k <= 50; ++k) EXPECT_NEAR(other[0][k], plain[0][k], 1e-7) << "before it begins";
  }
  for (const std::string& name : outside_physics_names()) {
    EXPECT_EQ(find_effect(name), -1) << "the catalogue has it by now";
    EXPECT_EQ(to_string(*outside_physics_named(name)), name);
  }
}

}  // namespace
}  // namespace lacuna
