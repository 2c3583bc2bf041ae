// Every effect: it vanishes at its neutral value to the last bit, and elsewhere does what its equation says.
#include <gtest/gtest.h>

#include "physics/actuators/table.h"
#include "physics/effects/table.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kStep = 0.002;        // s
constexpr double kRounding = 1e-11;    // rad, m: rounding accumulated over some thousand steps
constexpr double kIntegration = 1e-8;  // rad, m: fourth-order error at kStep of motions slower than 3 Hz

const Start kStill{{0.3, -0.4}, {0.2, -0.1}};

std::vector<ActuatorSpec> double_pendulum_drives() {
  std::vector<ActuatorSpec> out;
  for (const char* joint : {"shoulder", "elbow"}) {
    out.push_back(actuator(joint, "torque_source", {{"gain", 3.0}, {"damping", 0.7}, {"stiffness", 2.0}}));
  }
  return out;
}

Scenario double_pendulum(Prediction prediction) {
  auto robot = bundled_robot("double_pendulum/double_pendulum.urdf");
  Scenario scenario = driven_scenario(robot, double_pendulum_drives(), sine_drive(2, 2.0, 0.01, 2.0), kStill);
  scenario.prediction = prediction;
  return scenario;
}

struct NestingCase {
  const char* path;
  const char* engine;
  Prediction prediction;
};

class EffectNesting : public testing::TestWithParam<NestingCase> {};

TEST_P(EffectNesting, ReproducesThePlainModelToTheLastBitAtItsNeutralValueAtEveryPlace) {
  const Scenario scenario = double_pendulum(GetParam().prediction);
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStill);
  auto run = [&](const PlantModel& model) {
    // "scalar" is one lane of our own engine behind the interface that the other engines use.
    if (std::string(GetParam().path) != "scalar") return predict_one(model, experiment, on(GetParam().engine, kStep));
    std::vector<std::vector<std::vector<double>>> out;
    const std::vector<double> values = model.values();
    auto predictor = make_engine_predictor(GetParam().engine, model, experiment);
    for (const Segment& segment : experiment.segments) {
      const std::vector<LaneTask> one{{&values, &segment}};
      std::vector<std::vector<std::vector<double>>> predicted;
      predictor->predict(one, kStep, predicted);
      out.push_back(predicted.front());
    }
    return out;
  };
  const auto usual = run(plain);
  ASSERT_FALSE(usual.empty());
  ASSERT_TRUE(std::isfinite(usual.back().front().back()));
  ASSERT_GT(worst_difference(usual.front()[0], std::vector<double>(usual.front()[0].size(), kStill.q[0])), 0.01);
  for (const EffectInfo& info : effect_table()) {
    const PlantModel base(with_drives_for(info, scenario));
    const auto reference = needs_flow(find_effect(info.name)) ? run(base) : usual;
    std::vector<std::string> places{"arm"};
    if (info.where == Where::joint) {
      places.clear();
      for (const Joint& joint : scenario.robot->joints()) places.push_back(joint.name);
    }
    for (const std::string& place : places) {
      const auto neutral = run(base.with_effects({effect(info.name, place, {})}));
      if (std::string(info.name) == "base_compliance") {  // other bodies under the arm: other roundings
        for (std::size_t s = 0; s < reference.size(); ++s)
          EXPECT_LT(worst_difference(neutral[s][0], reference[s][0]), 1e-12);
        continue;
      }
      EXPECT_TRUE(same_bits(neutral, reference)) << info.name << " at " << place;
    }
  }
}

TEST(EffectNesting, HoldsOnChambers) {
  const Scenario scenario =
      load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/hydrolek/hydraulic/scenario.yaml");
  const Experiment experiment = make_experiment(scenario);
  const PlantModel plain(scenario);
  const PlantModel neutral = plain.with_effects({effect("leakage", "joint_2", {}), effect("relief", "joint_3", {})});
  EXPECT_TRUE(same_bits(predict_one(plain, experiment, on("featherstone", 0.01)),
                        predict_one(neutral, experiment, on("featherstone", 0.01))));
  EXPECT_THROW(plain.with_effects({effect("orifice_load_dependence", "joint_2", {})}), InputError)
      << "orifices know their load there";
}

INSTANTIATE_TEST_SUITE_P(All, EffectNesting,
                         testing::Values(NestingCase{"lanes_free_run", "featherstone", FreeRun{}},
                                         NestingCase{"lanes_windows", "featherstone", Windows{0.5}},
                                         NestingCase{"scalar", "featherstone", FreeRun{}}),
                         [](const auto& c) { return c.param.path; });

TEST(EffectNesting, HoldsOnEveryEngine) {
  const Scenario scenario = double_pendulum(FreeRun{});
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStill);
  const std::string joint = scenario.robot->joints()[1].name;
  const PlantModel neutral = plain.with_effects(
      {effect("coulomb_friction", joint, {}), effect("payload", "arm", {}), effect("input_delay", joint, {})});
  for (const std::string& engine : available_engines()) {
    EXPECT_TRUE(
        same_bits(predict_one(plain, experiment, on(engine, 0.01)), predict_one(neutral, experiment, on(engine, 0.01))))
        << engine;
  }
}

TEST(EffectNesting, CoversTheWholeCatalogueWithDistinctNamesAndNeutralDefaults) {
  std::vector<std::string> seen;
  for (const EffectInfo& info : effect_table()) {
    EXPECT_EQ(std::count(seen.begin(), seen.end(), info.name), 0) << info.name;
    seen.push_back(info.name);
    EXPECT_FALSE(info.parameters.empty()) << info.name;
    for (const ParameterInfo& p : info.parameters) {
      EXPECT_GE(p.neutral, p.lower) << info.name << "." << p.name;
      EXPECT_LE(p.neutral, p.upper) << info.name << "." << p.name;
    }
  }
  for (const char* name : {"coulomb_friction", "stribeck_friction", "valve_deadband", "valve_offset", "input_delay",
                           "actuator_saturation", "payload"}) {
    EXPECT_GE(find_effect(name), 0) << name;
  }
  EXPECT_EQ(find_effect("no_such_effect"), -1);
}

TEST(EffectStage, IsWhereTheEffectsHooksAct) {
  for (std::size_t i = 0; i < effect_table().size(); ++i) {
    const EffectInfo& info = effect_table()[i];
    const Hooks<double>& h = Effects::hooks<double>()[i];
    if (h.delay != nullptr) {
      EXPECT_EQ(info.stage, Stage::command) << info.name;
    }
    if (h.command != nullptr) {
      EXPECT_LE(info.stage, Stage::effort) << info.name;
    }
    if (h.sense != nullptr || h.measure != nullptr) {
      EXPECT_EQ(info.stage, Stage::reading) << info.name;
    }
    if (h.effort != nullptr || h.dry_friction != nullptr) {
      EXPECT_GT(info.stage, Stage::effort) << info.name;
    }
    if (h.inertials != nullptr || h.armature != nullptr || h.base != nullptr || h.gravity != nullptr) {
      EXPECT_EQ(info.stage, Stage::link) << info.name;
    }
  }
}

TEST(ActuatorRoles, AreTheParametersOfThoseNamesAndUnits) {
  const std::vector<ActuatorInfo>& table = actuator_table();
  for (std::size_t i = 0; i < table.size(); ++i) {
    const ActuatorInfo& info = table[i];
    const auto name = [&](int role) { return role < 0 ? std::string() : info.parameters[role].name; };
    const auto has = [&](const std::string& wanted) {
      return std::any_of(info.parameters.begin(), info.parameters.end(),
                         [&](const ParameterInfo& p) { return wanted == p.name; });
    };
    EXPECT_EQ(name(info.roles.gain), "gain") << info.name;
    EXPECT_EQ(name(info.roles.damping), has("damping") ? "damping" : "") << info.name;
    EXPECT_EQ(name(info.roles.stiffness), has("stiffness") ? "stiffness" : "") << info.name;
    EXPECT_EQ(name(info.roles.rest), has("rest") ? "rest" : "") << info.name;
    EXPECT_EQ(info.states, Actuators::hooks<double>()[i].states) << info.name;
    EXPECT_EQ(info.hydraulic, info.input == Stage::valve) << info.name;
  }
}

/// The block, pushed by u newtons.
Scenario pushed_block(const Drive& drive, const Start& start, double damping = 0.0) {
  return driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}, {"damping", damping}})},
                         drive, start);
}

/// Positions and speeds of the block with effects.
struct BlockRun {
  std::vector<double> q, v, t;
};
BlockRun run_block(const Drive& drive, double v0, const std::vector<EffectSpec>& effects,
                   const std::string& engine = "featherstone", double step = kStep) {
  const Start start{{0.0}, {v0}};
  const Scenario scenario = pushed_block(drive, start);
  const PlantModel model = PlantModel(scenario).with_effects(effects);
  const auto p = predict_one(model, started_experiment(scenario, start), on(engine, step)).front();
  return {p[0], p[1], drive.time};
}

TEST(CommandEffect, ActsOnTheBlockAsTheSameForceComputedByHand) {
  // Each effect's own equation, applied to the command before a plain run, gives the same motion.
  struct Case {
    EffectSpec spec;
    std::function<double(double)> by_hand;
  };
  const std::vector<Case> cases = {{effect("valve_offset", "slide", {{"b", 0.7}}), [](double u) { return u + 0.7; }},
                                   {effect("valve_deadband", "slide", {{"d", 0.9}}),
                                    [](double u) { return u > 0.9    ? u - 0.9
                                                          : u < -0.9 ? u + 0.9
                                                                     : 0.0; }},
                                   {effect("actuator_saturation", "slide", {{"cap", 1.3}}), [](double u) {
                                      return u * std::pow(1.0 + std::pow(std::fabs(u) / 1.3, 3.0), -1.0 / 3.0);
                                    }}};
  const Drive drive = sine_drive(1, 4.0, 0.01, 6.0);
  for (const Case& c : cases) {
    Drive changed = drive;
    for (double& u : changed.u[0]) u = c.by_hand(u);
    const BlockRun with = run_block(drive, 0.0, {c.spec}), by_hand = run_block(changed, 0.0, {});
    const BlockRun plain = run_block(drive, 0.0, {});
    EXPECT_LT(worst_difference(with.q, by_hand.q), kRounding) << c.spec.effect;
    EXPECT_GT(worst_difference(with.q, plain.q), 1e-2) << c.spec.effect << " changes nothing";
  }
}

TEST(CommandEffect, OrderIsDelayThenOffsetThenDeadbandThenSaturation) {
  const Drive drive = sine_drive(1, 2.0, 0.01, 5.0);
  Drive changed = drive;
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    const double u = drive.u[0][k < 3 ? 0 : k - 3] + 0.4;  // three samples late
    const double alive = std::copysign(std::max(std::fabs(u) - 0.5, 0.0), u);
    changed.u[0][k] = alive * std::pow(1.0 + std::pow(std::fabs(alive) / 2.0, 3.0), -1.0 / 3.0);
  }
  const BlockRun with = run_block(
      drive, 0.0,
      {effect("actuator_saturation", "slide", {{"cap", 2.0}}), effect("valve_deadband", "slide", {{"d", 0.5}}),
       effect("valve_offset", "slide", {{"b", 0.4}}), effect("input_delay", "slide", {{"T", 0.03}})});
  EXPECT_LT(worst_difference(with.q, run_block(changed, 0.0, {}).q), kRounding);
}

TEST(InputDelay, OfWholeSamplesShiftsTheResponseOfABlockAtRest) {
  const std::size_t late = 7;
  Drive drive = sine_drive(1, 2.0, 0.01, 4.0);
  drive.u[0][0] = 0.0;  // before the recording starts its first command is in force
  const BlockRun plain = run_block(drive, 0.0, {});
  const BlockRun with = run_block(drive, 0.0, {effect("input_delay", "slide", {{"T", 0.01 * late}})});
  for (std::size_t k = 0; k < late; ++k) EXPECT_NEAR(with.q[k], 0.0, kRounding);
  for (std::size_t k = late; k < with.q.size(); ++k) {
    ASSERT_NEAR(with.q[k], plain.q[k - late], kRounding) << "sample " << k;
  }
}

TEST(InputDelay, OfAFractionOfASampleMovesTheForceToItsExactInstant) {
  // A force of 3 N switched on at 0.50 s arrives at 0.50 + 0.0137 s: q = F (t - arrival)^2 / (2 m).
  Drive drive = constant_drive(1, 1.0, 0.01, 0.0);
  for (std::size_t k = 50; k < drive.time.size(); ++k) drive.u[0][k] = 3.0;
  const BlockRun with = run_block(drive, 0.0, {effect("input_delay", "slide", {{"T", 0.0137}})}, "featherstone", 0.01);
  for (std::size_t k = 0; k < with.t.size(); ++k) {
    const double moving = std::max(0.0, with.t[k] - drive.time[50] - 0.0137);
    ASSERT_NEAR(with.q[k], 3.0 * moving * moving / (2.0 * kBlockMass), kRounding) << "t = " << with.t[k];
  }
}

TEST(CoulombFriction, StopsASlidingBlockAtTheClosedFormPlaceAndInstantForGood) {
  const double Fc = 3.0, v0 = 1.234, mu = Fc / kBlockMass;  // m/s^2
  for (const std::string& engine : available_engines()) {
    for (const double sense : {1.0, -1.0}) {
      // ODE's acceleration comes from tiny steps: documented relative error 1e-5.
      const double tolerance = engine == "ode" ? 1e-5 : 1e-10;
      const BlockRun run = run_block(constant_drive(1, 1.5, 0.01, 0.0), sense * v0,
                                     {effect("coulomb_friction", "slide", {{"Fc", Fc}})}, engine, 0.01);
      const double stop = v0 / mu;  // s
      for (std::size_t k = 0; k < run.t.size(); ++k) {
        const double t = std::min(run.t[k], stop);
        ASSERT_NEAR(run.q[k], sense * (v0 * t - 0.5 * mu * t * t), tolerance) << engine << " t = " << run.t[k];
        if (run.t[k] > stop) {
          ASSERT_EQ(run.v[k], 0.0) << engine << " t = " << run.t[k];
        }
      }
      EXPECT_NEAR(run.q.back(), sense * v0 * v0 / (2.0 * mu), tolerance) << engine;
    }
  }
}

TEST(CoulombFriction, HoldsABlockUnderASmallerForceAndLetsItGoUnderALargerOne) {
  const double Fc = 5.0;
  for (const std::string& engine : available_engines()) {
    const BlockRun held = run_block(constant_drive(1, 2.0, 0.01, 0.999 * Fc), 0.0,
                                    {effect("coulomb_friction", "slide", {{"Fc", Fc}})}, engine, 0.01);
    for (std::size_t k = 0; k < held.t.size(); ++k) {
      ASSERT_EQ(held.q[k], 0.0) << engine;
      ASSERT_EQ(held.v[k], 0.0) << engine;
    }
    const BlockRun pushed = run_block(constant_drive(1, 2.0, 0.01, 1.5 * Fc), 0.0,
                                      {effect("coulomb_friction", "slide", {{"Fc", Fc}})}, engine, 0.01);
    const double a = 0.5 * Fc / kBlockMass;
    const double tolerance = engine == "ode" ? 1e-4 : 1e-10;  // of 2.5 m/s: ODE's relative error 1e-5
    EXPECT_NEAR(pushed.v.back(), a * 2.0, tolerance) << engine;
    EXPECT_NEAR(pushed.q.back(), 0.5 * a * 4.0, tolerance) << engine;
  }
}

TEST(CoulombFriction, ReversesABlockThroughAStickPhaseAsTheClosedFormSays) {
  // +v0 against friction and 2 Fc of force backwards: decelerates at 3 mu, passes zero without resting, returns at mu.
  const double Fc = 2.0, v0 = 0.9, mu = Fc / kBlockMass;
  const BlockRun run = run_block(constant_drive(1, 1.5, 0.01, -2.0 * Fc), v0,
                                 {effect("coulomb_friction", "slide", {{"Fc", Fc}})}, "featherstone", 0.01);
  const double turn = v0 / (3.0 * mu), reach = 0.5 * v0 * turn;
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const double t = run.t[k], back = std::max(0.0, t - turn), ahead = std::min(t, turn);
    const double expected = t < turn ? v0 * ahead - 1.5 * mu * ahead * ahead : reach - 0.5 * mu * back * back;
    ASSERT_NEAR(run.q[k], expected, 1e-10) << "t = " << t;
  }
}

TEST(CoulombFriction, ThatCreepsFollowsItsSmoothEquation) {
  // m v' = -Fc tanh(v/v0): sinh(v/v0) = sinh(v(0)/v0) exp(-Fc t / (m v0)).
  const double Fc = 0.8, creep = 0.5, start = 0.9;
  const BlockRun run = run_block(constant_drive(1, 3.0, 0.01, 0.0), start,
                                 {effect("coulomb_friction", "slide", {{"Fc", Fc}, {"v0", creep}})});
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const double expected =
        creep * std::asinh(std::sinh(start / creep) * std::exp(-Fc * run.t[k] / (kBlockMass * creep)));
    ASSERT_NEAR(run.v[k], expected, kIntegration) << "t = " << run.t[k];
  }
}

TEST(CoulombAsymmetry, HoldsAndLetsGoByTheDirectionOfThePull) {
  const EffectSpec spec = effect("coulomb_asymmetry", "slide", {{"Fc_up", 5.0}, {"Fc_down", 2.0}});
  for (const std::string& engine : available_engines()) {
    for (const double held : {4.99, 1.0, -1.0, -1.99})
      EXPECT_EQ(run_block(constant_drive(1, 0.5, 0.01, held), 0.0, {spec}, engine, 0.01).q.back(), 0.0)
          << engine << " " << held;
    for (const double push : {7.0, -4.0}) {
      const double left = push > 0.0 ? push - 5.0 : push + 2.0;  // N
      EXPECT_NEAR(run_block(constant_drive(1, 2.0, 0.01, push), 0.0, {spec}, engine, 0.01).v.back(),
                  left / kBlockMass * 2.0, engine == "ode" ? 1e-4 : 1e-10)
          << engine;
    }
  }
}

TEST(CoulombAsymmetry, IsCoulombFrictionBesideAnOffset) {
  const Drive drive = sine_drive(1, 4.0, 0.01, 9.0);
  const BlockRun one =
      run_block(drive, 0.4, {effect("coulomb_asymmetry", "slide", {{"Fc_up", 1.7}, {"Fc_down", 0.9}})});
  const BlockRun two = run_block(
      drive, 0.4,
      {effect("coulomb_friction", "slide", {{"Fc", 1.3}}), effect("torque_offset", "slide", {{"tau0", -0.4}})});
  EXPECT_LT(worst_difference(one.q, two.q), kRounding);
  const BlockRun equal =
      run_block(drive, 0.4, {effect("coulomb_asymmetry", "slide", {{"Fc_up", 1.3}, {"Fc_down", 1.3}})});
  EXPECT_TRUE(same_bits(equal.q, run_block(drive, 0.4, {effect("coulomb_friction", "slide", {{"Fc", 1.3}})}).q));
  EXPECT_GT(worst_difference(one.q, equal.q), 1e-2) << "nothing was tested";
}

TEST(CoulombAsymmetry, WithstandsByDirectionWhereEffortsArePredictedToo) {
  const Start start{{0.0}, {0.0}};
  const Drive drive = sine_drive(1, 4.0, 0.01, 9.0);
  Scenario scenario = pushed_block(drive, start);
  scenario.recordings.clear();
  add_recording(scenario, simulated_recording(pushed_block(drive, start), drive, start, "featherstone", "run.csv"));
  scenario.prediction = InverseDynamics{5.0};
  const Experiment experiment = make_experiment(scenario);
  const auto needed = [&](const std::vector<EffectSpec>& effects) {
    return predict_one(PlantModel(scenario).with_effects(effects), experiment, on("featherstone", kStep)).front()[0];
  };
  const auto one = needed({effect("coulomb_asymmetry", "slide", {{"Fc_up", 1.7}, {"Fc_down", 0.9}})});
  const auto two =
      needed({effect("coulomb_friction", "slide", {{"Fc", 1.3}}), effect("torque_offset", "slide", {{"tau0", -0.4}})});
  EXPECT_LT(worst_difference(one, two), kRounding);
  EXPECT_GT(worst_difference(one, needed({effect("coulomb_friction", "slide", {{"Fc", 1.3}})})), 0.3);
}

TEST(CoulombAsymmetry, OfOneDirectionOnlyIsARatchet) {
  // Nothing withstands negative motion; positive pulls below 3 N are held.
  const EffectSpec spec = effect("coulomb_asymmetry", "slide", {{"Fc_up", 3.0}});
  EXPECT_EQ(run_block(constant_drive(1, 0.5, 0.01, 2.9), 0.0, {spec}).q.back(), 0.0);
  EXPECT_NEAR(run_block(constant_drive(1, 0.5, 0.01, -1.0), 0.0, {spec}).v.back(), -0.5 / kBlockMass, 1e-10);
}

TEST(StribeckFriction, SlidesAtNoLessThanItsBreakAwayEffort) {
  const Drive drive = sine_drive(1, 3.0, 0.01, 6.0);
  const Start start{{0.0}, {0.3}};
  const Scenario scenario = pushed_block(drive, start);
  const PlantModel model =
      PlantModel(scenario).with_effects({effect("stribeck_friction", "slide", {{"Fc", 1.5}, {"Fs", 1.5}})});
  std::vector<double> values = model.values();
  values[model.find("slide.stribeck_friction.Fs")] = 0.4;  // as a search may ask
  const Experiment experiment = started_experiment(scenario, start);
  const auto asked = predict(model, experiment, {values, model.values()}, on("featherstone", kStep));
  EXPECT_TRUE(same_bits(asked[0], asked[1]));
}

TEST(StribeckFriction, BreaksAwayAtItsStaticEffortAndSlidesAtItsOwnCurve) {
  const EffectSpec spec = effect("stribeck_friction", "slide", {{"Fc", 2.0}, {"Fs", 5.0}, {"vs", 0.3}});
  const BlockRun held = run_block(constant_drive(1, 1.0, 0.01, 4.99), 0.0, {spec});
  EXPECT_EQ(held.q.back(), 0.0);
  const BlockRun pushed = run_block(constant_drive(1, 1.0, 0.01, 6.0), 0.0, {spec});
  EXPECT_GT(pushed.q.back(), 0.1);
  // Reference: the same equation stepped by Euler a hundred thousand times a second, no lacuna code.
  double v = 0.0, q = 0.0;
  const int fine = 200000;
  for (int k = 0; k < fine; ++k) {
    const double friction = 2.0 + 3.0 * std::exp(-(v / 0.3) * (v / 0.3));
    const double next = v + (6.0 - friction) / kBlockMass / fine;
    q += 0.5 * (v + next) / fine;
    v = next;
  }
  EXPECT_NEAR(pushed.q.back(), q, 1e-4 * q);  // the reference is of first order
}

TEST(StribeckFriction, WithEqualEffortsIsCoulombFriction) {
  const Drive drive = sine_drive(1, 3.0, 0.01, 6.0);
  const BlockRun a = run_block(drive, 0.3, {effect("stribeck_friction", "slide", {{"Fc", 1.5}, {"Fs", 1.5}})});
  const BlockRun b = run_block(drive, 0.3, {effect("coulomb_friction", "slide", {{"Fc", 1.5}})});
  EXPECT_LT(worst_difference(a.q, b.q), kRounding);
}

TEST(Payload, IsTheSameRobotWithTheMassWeldedToItsTool) {
  const double mass = 0.8;
  auto robot = bundled_robot("pendulum/pendulum.urdf");
  const Robot::Tool& tool = robot->tool();
  std::vector<Link> links = robot->links();
  for (Link& link : links) {
    if (link.body != tool.body || link.inertial.mass <= 0.0) continue;
    const Eigen::Vector3d point = link.in_body.inverse() * tool.point;
    link.inertial = welded(link.inertial, {mass, point, Eigen::Matrix3d::Zero()});
  }
  auto heavier = std::make_shared<const Robot>(robot->name(), robot->joints(), links, "heavier");
  const std::string joint = robot->joints()[0].name;
  const Start start{{0.7}, {0.0}};
  const Drive drive = sine_drive(1, 2.0, 0.01, 2.0);
  const std::vector<ActuatorSpec> drives{
      actuator(joint, "torque_source", {{"gain", 1.0}, {"damping", 0.1}, {"stiffness", 0.5}})};
  const Scenario light = driven_scenario(robot, drives, drive, start),
                 heavy = driven_scenario(heavier, drives, drive, start);
  const PlantModel carrying = PlantModel(light).with_effects({effect("payload", "arm", {{"m", mass}})});
  for (const std::string& engine : available_engines()) {
    const auto a = predict_one(carrying, started_experiment(light, start), on(engine, kStep)).front();
    const auto b = predict_one(PlantModel(heavy), started_experiment(heavy, start), on(engine, kStep)).front();
    const auto without = predict_one(PlantModel(light), started_experiment(light, start), on(engine, kStep)).front();
    EXPECT_LT(worst_difference(a[0], b[0]), 1e-9) << engine;  // the two inertias round differently
    EXPECT_GT(worst_difference(a[0], without[0]), 1e-2) << engine;
  }
}

TEST(Payload, ActsOnlyInTheRecordingsThatAreNamed) {
  auto robot = bundled_robot("pendulum/pendulum.urdf");
  const Start start{{0.7}, {0.0}};
  const Drive drive = constant_drive(1, 1.0, 0.01, 0.0);
  Scenario scenario = bare_scenario(robot, {});
  add_recording(scenario, recording_of(*robot, drive, start, "loaded.csv"));
  add_recording(scenario, recording_of(*robot, drive, start, "empty.csv"));
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, start);
  // A payload above the swing's centre of oscillation changes the period.
  const PlantModel loaded = plain.with_effects({effect("payload", "arm", {{"m", 2.0}}, {"loaded.csv"})});
  const auto a = predict_one(plain, experiment, on("featherstone", kStep));
  const auto b = predict_one(loaded, experiment, on("featherstone", kStep));
  EXPECT_TRUE(same_bits(a[1], b[1]));
  EXPECT_GT(worst_difference(a[0][0], b[0][0]), 1e-3);
}

TEST(Actuators, OfNegativeGainAreThoseOfPositiveGainUnderTheOppositeCommand) {
  const Start start{{0.1}, {0.0}};
  const Drive drive = sine_drive(1, 2.0, 0.01, 2.0);
  Drive opposite = drive;
  for (double& u : opposite.u[0]) u = -u;
  const std::map<std::string, std::map<std::string, double>> models = {
      {"torque_source", {{"damping", 2.0}, {"stiffness", 5.0}}},
      {"flow_source", {{"damping", 40.0}, {"stiffness", 800.0}}},
      {"direct_effort", {{"damping", 2.0}}},
      {"hydraulic",
       {{"full_command", 1e9},  // of gains of 3: flows of some litres a minute
        {"area_a", 1e-3},
        {"area_b", 8e-4},
        {"dead_volume_a", 1e-4},
        {"dead_volume_b", 1e-4},
        {"stroke", 0.5},
        {"supply_pressure", 2e7}}}};
  for (const auto& [model, others] : models) {
    const auto moved = [&, &model = model](double gain, const Drive& by) {
      std::map<std::string, double> p = others;
      p["gain"] = gain;
      const Scenario scenario = driven_scenario(block_robot(), {actuator("slide", model, p)}, by, start);
      return predict_one(PlantModel(scenario), started_experiment(scenario, start), on("featherstone", kStep));
    };
    EXPECT_TRUE(same_bits(moved(-3.0, drive), moved(3.0, opposite))) << model;
  }
}

TEST(Actuators, FollowTheirClosedForms) {
  // torque_source on the block: a damped spring, x = rest + gain u / stiffness + decaying oscillation.
  const double S = 32.0, D = 4.0, K = 2.0, u = 1.5, rest = 0.1;
  const Start start{{0.0}, {0.0}};
  const Drive drive = constant_drive(1, 3.0, 0.01, u);
  const Scenario spring = driven_scenario(
      block_robot(),
      {actuator("slide", "torque_source", {{"gain", K}, {"damping", D}, {"stiffness", S}, {"rest", rest}})}, drive,
      start);
  const auto p = predict_one(PlantModel(spring), started_experiment(spring, start), on("featherstone", kStep)).front();
  const double target = rest + K * u / S, decay = D / (2.0 * kBlockMass),
               omega = std::sqrt(S / kBlockMass - decay * decay);
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    const double t = drive.time[k];
    const double x =
        target * (1.0 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    ASSERT_NEAR(p[0][k], x, kIntegration) << "torque_source t = " << t;
  }
  // direct_effort: m v' = K u - D v.
  const Scenario direct =
      driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", K}, {"damping", D}})}, drive, start);
  const auto d = predict_one(PlantModel(direct), started_experiment(direct, start), on("featherstone", kStep)).front();
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    ASSERT_NEAR(d[1][k], K * u / D * (1.0 - std::exp(-D / kBlockMass * drive.time[k])), kIntegration);
  }
  // flow_source: the command is a speed once the oil spring has settled.
  const Scenario flow = driven_scenario(
      block_robot(), {actuator("slide", "flow_source", {{"gain", 0.2}, {"stiffness", 800.0}, {"damping", 40.0}})},
      drive, start);
  const auto f = predict_one(PlantModel(flow), started_experiment(flow, start), on("featherstone", kStep)).front();
  EXPECT_NEAR(f[1].back(), 0.2 * u, 1e-6);  // exp(-10 * 3) of the start is left
  EXPECT_NEAR(f[0].back(), 0.2 * u * 3.0, 1e-6);
}

}  // namespace
}  // namespace lacuna
