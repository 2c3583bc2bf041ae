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
  options.settle = !integrates_flow(model.actuators()[0].type);  // under a command it never comes to rest
  auto truth = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  for (std::size_t j = 0; j < truth.size(); ++j) experiment.segments[0].q0[j] = truth[j][0];
  if (options.settle) experiment.segments[0].v0.assign(truth.size(), 0.0);
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
    data->columns[data->find("q_" + scenario.robot->joints()[j].name)] = truth[j];
  moved.recordings[0].data = data;
  return make_experiment(moved);
}

TEST(Truth, AgreesWithTheRolloutForEveryEffect) {
  const Scenario scenario = two_rods();
  const Experiment moved = moved_by_the_truth(scenario);
  for (const EffectInfo& info : effect_table()) {
    const PlantModel model = with_typical(with_drives_for(info, scenario), info, moved);
    EXPECT_LT(disagreement(model, moved, "featherstone"), kEngineAgreement) << info.name;
  }
}

TEST(Lanes, EqualDoubleForEveryEffect) {
  // rad: roundings of either path, which events (a joint that sticks a step earlier) may carry on.
  constexpr double kRounding = 1e-9;
  const Scenario scenario = two_rods();
  const Experiment moved = moved_by_the_truth(scenario);
  for (const EffectInfo& info : effect_table()) {
    const PlantModel model = with_typical(with_drives_for(info, scenario), info, moved);
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

using Kind = OutsidePhysics::Kind;

std::vector<std::vector<double>> moved_with(const Scenario& scenario, std::vector<OutsidePhysics> outside,
                                            double tolerance = 1e-8) {
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  TruthOptions options = on_featherstone();
  options.outside = std::move(outside);
  options.tolerance = tolerance;
  options.settle = false;
  return simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
}

/// A block on a level slide under a constant command, without friction of its own.
Scenario pushed_block(double command, double speed, double seconds = 1.0) {
  return driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}, {"damping", 0.0}})},
                         constant_drive(1, seconds, 0.01, command), {{0.0}, {speed}, true});
}

TEST(Truth, PhysicsOutsideTheCatalogueActs) {
  const Scenario scenario = two_rods();
  const auto plain = moved_with(scenario, {});
  EXPECT_GT(worst_difference(moved_with(scenario, {{Kind::position_ripple, 0, 0.5, {}}})[0], plain[0]), 1e-3);
  for (const Kind kind : {Kind::external_push, Kind::command_dropout}) {
    const auto other = moved_with(scenario, {{kind, 0, 0.5, {{1.0}}}});
    EXPECT_GT(worst_difference(other[0], plain[0]), 1e-3) << to_string(kind);
    for (std::size_t k = 0; k <= 50; ++k) EXPECT_NEAR(other[0][k], plain[0][k], 1e-7) << "before it begins";
  }
  EXPECT_EQ(moved_with(scenario, {{Kind::repeated_samples, 0, 0.5, {{1.0}}}}), plain) << "the machine does not know";
}

TEST(Outside, HasANameOfItsOwnForEveryKind) {
  for (const OutsideInfo& info : outside_table()) {
    EXPECT_EQ(find_effect(info.name), -1) << "the catalogue has it by now";
    EXPECT_EQ(outside_physics_named(info.name), info.kind);
    EXPECT_EQ(&info_of(info.kind), &info) << info.name;
    EXPECT_STREQ(to_string(info.kind), info.name);
  }
  EXPECT_EQ(outside_physics_named("coulomb_friction"), std::nullopt);
}

TEST(Outside, SpringAndRippleKeepTheEnergy) {
  constexpr double kLost = 1e-7;  // J, in a second at this tolerance
  const OutsidePhysics spring{Kind::counterbalance_spring, 0, 30.0, {}, {.centre = 0.4, .lever = 0.6, .length = 0.5}};
  const OutsidePhysics ripple{Kind::position_ripple, 0, 20.0, {}, {.centre = 0.1, .width = 0.3}};
  // s / lever (l^2 / 2 - length l) has the derivative s (1 - length / l) sin(theta); the effort is minus a potential's.
  const auto of_spring = [&](double q) {
    const double l = std::sqrt(1.0 + 0.36 - 1.2 * std::cos(q - 0.4));
    return -30.0 / 0.6 * (0.5 * l * l - 0.5 * l);
  };
  const auto of_ripple = [](double q) {
    const double radians = 2.0 * std::numbers::pi / 0.3;
    return 20.0 / radians * std::cos(radians * (q - 0.1));
  };
  const auto check = [&](const OutsidePhysics& physics, const auto& potential) {
    const auto moved = moved_with(pushed_block(0.0, 0.9), {physics}, 1e-10);
    const auto energy = [&](std::size_t k) {
      return 0.5 * kBlockMass * moved[1][k] * moved[1][k] + potential(moved[0][k]);
    };
    double slowest = HUGE_VAL, fastest = 0.0;
    for (std::size_t k = 0; k < moved[0].size(); ++k) {
      EXPECT_NEAR(energy(k), energy(0), kLost) << to_string(physics.kind) << " at sample " << k;
      slowest = std::min(slowest, std::fabs(moved[1][k]));
      fastest = std::max(fastest, std::fabs(moved[1][k]));
    }
    EXPECT_GT(fastest - slowest, 0.1) << to_string(physics.kind) << " does nothing";
  };
  check(spring, of_spring);
  check(ripple, of_ripple);
}

TEST(Outside, ATightSpotTakesItsAreaOfTheEnergyEitherWay) {
  // Crossed well above `slow`, it takes the area below its bell: s width sqrt(pi).
  const OutsidePhysics spot{Kind::tight_spot, 0, 3.0, {}, {.centre = 0.5, .width = 0.1, .slow = 1e-3}};
  for (const double way : {1.0, -1.0}) {
    OutsidePhysics there = spot;
    there.form.centre *= way;
    const auto moved = moved_with(pushed_block(0.0, way * 2.0), {there}, 1e-10);
    const double speed = moved[1].back();
    EXPECT_NEAR(0.5 * kBlockMass * (4.0 - speed * speed), 3.0 * 0.1 * std::sqrt(std::numbers::pi), 1e-6);
  }
}

TEST(Outside, ATightSpotDoesNotMoveWhatRests) {
  const OutsidePhysics spot{Kind::tight_spot, 0, 3.0, {}, {.centre = 0.0, .width = 0.1, .slow = 1e-3}};
  const auto moved = moved_with(pushed_block(0.0, 0.0), {spot});
  for (const double q : moved[0]) EXPECT_EQ(q, 0.0);
}

TEST(Outside, ANotchAltersTheCommandAndNothingElse) {
  const OutsidePhysics notch{Kind::valve_notch, 0, 0.7, {}, {.centre = 1.5, .width = 0.4}};
  for (const double told : {1.2, -1.2, 0.0}) {
    const double arrives = told - 0.7 * std::exp(-std::pow((told - 1.5) / 0.4, 2));
    const auto moved = moved_with(pushed_block(told, 0.0), {notch});
    EXPECT_EQ(moved, moved_with(pushed_block(arrives, 0.0), {})) << told;
    EXPECT_NEAR(moved[1].back(), arrives / kBlockMass, 1e-9) << told;
  }
}

TEST(Outside, ACableOverTheNextJointPullsAtItsOwn) {
  // Shoulder's effort, by what must be added there to undo it: the same law with the other sign.
  const Scenario scenario = two_rods();
  const OutsidePhysics cable{Kind::cable_drag, 0, 0.8, {}, {.centre = 0.1, .width = 0.2, .other = 1}};
  OutsidePhysics against = cable;
  against.strength = -cable.strength;
  const auto plain = moved_with(scenario, {});
  EXPECT_GT(worst_difference(moved_with(scenario, {cable})[0], plain[0]), 1e-2);
  EXPECT_LT(worst_difference(moved_with(scenario, {cable, against})[0], plain[0]), 1e-12);
  EXPECT_EQ(outside_law(cable, 0.1), 0.0);
  EXPECT_NEAR(outside_law(cable, 0.3), 0.8 * std::tanh(1.0), 1e-15);
  // Far from its middle it is a constant push: the same motion as with another command.
  OutsidePhysics taut = cable;
  taut.form.centre = -20.0;
  Scenario pushed = scenario;
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (double& u : data->columns[data->find("u_shoulder")]) u += 0.8 / 4.0;
  pushed.recordings[0].data = data;
  EXPECT_LT(worst_difference(moved_with(scenario, {taut})[0], moved_with(pushed, {})[0]), 1e-9);
}

TEST(Outside, BeyondALineNothingIsLeftOfALine) {
  std::vector<std::vector<double>> at;
  std::vector<double> plane, bent, curve;
  for (const double direction : {-1.0, 1.0}) {
    for (int k = 0; k <= 20; ++k) {
      const double x = 3.0 + 0.1 * k;
      at.push_back({x, direction});
      plane.push_back(2.0 - 3.0 * x + 4.0 * direction);
      curve.push_back(direction * std::sin(x));
      bent.push_back(plane.back() + curve.back());
    }
  }
  EXPECT_LT(root_mean_square(beyond_linear(at, plane)), 1e-12);
  EXPECT_LT(worst_difference(beyond_linear(at, bent), beyond_linear(at, curve)), 1e-12);
  EXPECT_GT(root_mean_square(beyond_linear(at, curve)), 0.1);
  EXPECT_TRUE(beyond_linear({}, {}).empty());
}

}  // namespace
}  // namespace lacuna
