// Effects with a past, a reading or a direction, against the same laws written out by hand and stepped finely.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>

#include "physics/pseudo_inertia.h"
#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kGain = 9.0, kDamping = 3.0, kStiffness = 40.0, kRest = 0.1;  // N/V, N s/m, N/m, m
constexpr double kFine = 2e-5;                                                 // s, step of the hand-written laws
constexpr double kAgreement = 2e-5;                                            // m, of a motion of some 0.5 m
const Start kStart{{0.15}, {0.0}};

/// The block with what one law may remember.
struct Block {
  double t = 0.0, x = 0.15, v = 0.0, u = 0.0;
  double past[2] = {0.0, 0.0};
  double drive(double command) const { return kGain * command - kDamping * v - kStiffness * (x - kRest); }
};

struct Law {
  const char* effect;
  std::map<std::string, double> parameters;
  std::function<double(const Block&)> force;               // N
  std::function<void(Block&, double)> begin = nullptr;     // at the start
  std::function<void(Block&, double)> remember = nullptr;  // after each fine step of that length
  std::function<double(const Block&)> reading = nullptr;   // else x
  double agreement = kAgreement;                           // m
  double fine = kFine;                                     // s
};

double capped(double x, double n) { return x * std::pow(1.0 + std::pow(x, n), -1.0 / n); }
double sgn(double x) { return (x > 0.0) - (x < 0.0); }
double played(double past, double x, double half) { return std::max(std::min(past, x + half), x - half); }

/// What lies between actuator and link below, by an explicit rule of first order; past: angle and speed of the
/// actuator's side.
constexpr double kSpring = 900.0, kLoss = 6.0, kSide = 0.4;  // N/m, N s/m, kg
double pull(const Block& b, double half, double loss) {
  const double lead = b.past[0] - b.x, damped = loss * (b.past[1] - b.v);
  if (lead > half) return std::max(kSpring * (lead - half) + damped, half > 0.0 ? 0.0 : -HUGE_VAL);
  if (lead < -half) return std::min(kSpring * (lead + half) + damped, half > 0.0 ? 0.0 : HUGE_VAL);
  return 0.0;
}
std::function<void(Block&, double)> settle(double half) {
  return [half](Block& b, double) {
    b.past[0] = b.x + (b.drive(b.u) + kSpring * half) / (kStiffness + kSpring);
    b.past[1] = b.v;
  };
}
std::function<void(Block&, double)> cross(double half, double loss) {
  return [half, loss](Block& b, double dt) {
    const double push = b.drive(b.u) - kDamping * (b.past[1] - b.v) - kStiffness * (b.past[0] - b.x);
    b.past[1] += dt * (push - pull(b, half, loss)) / kSide;
    b.past[0] += dt * b.past[1];
  };
}

Law transmission(const char* effect, double half, double loss) {
  std::map<std::string, double> parameters{{"k", kSpring}, {"J", kSide}};
  if (half > 0.0) parameters["gap"] = half;
  if (loss > 0.0) parameters["c"] = loss;
  constexpr double kHand = 1e-4, kHandStep = 2e-6;  // m, s: the explicit rule's own
  return {effect,       parameters,        [=](const Block& b) { return pull(b, half, loss); },
          settle(half), cross(half, loss), nullptr,
          kHand,        kHandStep};
}

/// Bristles of 200 N/m up to 2 N, past: their effort, N, and where that was. Over no time they take what the drive does
/// not need to hold the block.
std::function<void(Block&, double)> bend() {
  return [](Block& b, double dt) {
    const double way = b.x - b.past[1];
    b.past[0] =
        dt > 0.0 ? b.past[0] + 200.0 * (1.0 - b.past[0] * sgn(way) / 2.0) * way : std::clamp(b.drive(b.u), -2.0, 2.0);
    b.past[1] = b.x;
  };
}

const std::vector<Law>& laws() {
  static const std::vector<Law> all = {
      {"actuator_lag",
       {{"T", 0.08}},
       [](const Block& b) { return b.drive(b.past[0]); },
       [](Block& b, double) { b.past[0] = b.u; },
       [](Block& b, double dt) { b.past[0] = b.u + (b.past[0] - b.u) * std::exp(-dt / 0.08); }},
      {"valve_hysteresis",
       {{"h", 0.4}},
       [](const Block& b) { return b.drive(played(b.past[0], b.u, 0.4)); },
       [](Block& b, double) { b.past[0] = b.u; },
       [](Block& b, double) { b.past[0] = played(b.past[0], b.u, 0.4); }},
      {"valve_asymmetry", {{"a", 0.3}}, [](const Block& b) { return b.drive(b.u < 0.0 ? 0.7 * b.u : b.u); }},
      {"valve_opening",
       {{"c", 0.6}, {"full", 1.5}},
       [](const Block& b) { return b.drive(b.u * (0.4 + 0.6 * std::fabs(b.u) / 1.5)); }},
      {"valve_drift",
       {{"b", 0.8}, {"tau", 0.6}},
       [](const Block& b) { return b.drive(b.u + 0.8 * (1.0 - std::exp(-b.t / 0.6))); }},
      {"lever_arm_variation",
       {{"ratio", 0.5}, {"phase", 0.7}},
       [](const Block& b) { return b.drive(b.u * (1.0 + 0.5 * (std::sin(b.x + 0.7) - std::sin(0.7)))); }},
      {"supply_pressure_sag",
       {{"depth", 0.4}, {"flow_slide", 1.5}},
       [](const Block& b) { return b.drive(b.u * (1.0 - 0.4 * capped(std::fabs(b.v) / 1.5, 3.0))); }},
      {"shared_supply",
       {{"full_slide", 1.2}},
       [](const Block& b) { return b.drive(sgn(b.u) * 1.2 * capped(std::fabs(b.u) / 1.2, 8.0)); }},
      {"load_dependent_friction",
       {{"mu", 0.2}, {"v0", 0.05}},
       [](const Block& b) {
         const double load = b.drive(b.u) + kDamping * b.v;
         return b.drive(b.u) - 0.2 * std::fabs(load) * std::tanh(b.v / 0.05);
       }},
      {"load_dependent_friction",
       {{"mu", 0.2}},
       [](const Block& b) {
         const double load = b.drive(b.u) + kDamping * b.v;
         return b.drive(b.u) - 0.2 * std::fabs(load) * std::tanh(b.v / 1e-4);
       },
       nullptr,
       nullptr,
       nullptr,
       5e-5,  // the hand creeps at some 1e-4 m/s where the block should stand
       2e-6},
      {"hysteresis_friction",
       {{"Fc", 2.0}, {"sigma0", 200.0}},
       [](const Block& b) { return b.drive(b.u) - b.past[0]; },
       bend(),
       bend()},
      {"hysteresis_friction",
       {{"Fc", 2.0}, {"sigma0", 200.0}, {"sigma1", 4.0}},
       [](const Block& b) { return b.drive(b.u) - b.past[0] - 4.0 * (b.v - std::fabs(b.v) * b.past[0] / 2.0); },
       bend(),
       bend()},
      {"coulomb_asymmetry",
       {{"Fc_up", 2.0}, {"Fc_down", 0.7}, {"v0", 0.05}},
       [](const Block& b) { return b.drive(b.u) - (b.v > 0.0 ? 2.0 : 0.7) * std::tanh(b.v / 0.05); }},
      {"viscous_friction", {{"D", 2.0}}, [](const Block& b) { return b.drive(b.u) - 2.0 * b.v; }},
      {"power_friction",
       {{"c", 2.0}, {"p", 0.4}, {"v0", 0.02}},
       [](const Block& b) { return b.drive(b.u) - 2.0 * b.v * std::pow(std::hypot(b.v, 0.02), 0.4 - 1.0); }},
      {"torque_offset", {{"tau0", -1.5}}, [](const Block& b) { return b.drive(b.u) - 1.5; }},
      {"gravity_spring",
       {{"a", 6.0}, {"b", -3.0}},
       [](const Block& b) { return b.drive(b.u) - 6.0 * std::sin(b.x) + 3.0 * std::cos(b.x); }},
      {"gear_ripple",
       {{"a", 3.0}, {"b", 1.5}, {"n", 12.0}},
       [](const Block& b) { return b.drive(b.u) + 3.0 * std::sin(12.0 * b.x) + 1.5 * std::cos(12.0 * b.x); }},
      {"quadratic_damping", {{"c", 2.0}}, [](const Block& b) { return b.drive(b.u) - 2.0 * std::fabs(b.v) * b.v; }},
      {"damping_asymmetry",
       {{"a", 0.8}},
       [](const Block& b) { return b.drive(b.u) - (b.v < 0.0 ? 0.8 * kDamping * b.v : 0.0); }},
      {"stiffness_hardening",
       {{"k3", 60.0}},
       [](const Block& b) { return b.drive(b.u) - 60.0 * std::pow(b.x - kRest, 3); }},
      {"end_stop",
       {{"q_lim", 0.3}, {"k", 400.0}},
       [](const Block& b) { return b.drive(b.u) - 400.0 * std::max(b.x - 0.3, 0.0); }},
      {"end_stop",
       {{"q_lim", 0.0}, {"k", -400.0}},
       [](const Block& b) { return b.drive(b.u) + 400.0 * std::max(0.0 - b.x, 0.0); }},
      {"end_stop",
       {{"q_lim", 0.3}, {"k", 400.0}, {"travel", 0.25}},
       [](const Block& b) {
         return b.drive(b.u) - 400.0 * std::max(b.x - 0.3, 0.0) + 400.0 * std::max(0.05 - b.x, 0.0);
       }},
      {"end_stop",
       {{"q_lim", 0.2}, {"k", 400.0}, {"T", 0.05}},
       [](const Block& b) { return b.drive(b.u) - (b.x > 0.2 ? 400.0 * std::max(b.x - 0.2 + 0.05 * b.v, 0.0) : 0.0); },
       nullptr,
       nullptr,
       nullptr,
       3e-4},  // the block meets the damper inside a step of 1 ms
      transmission("backlash", 0.05, 0.0),
      transmission("backlash", 0.05, kLoss),
      transmission("joint_compliance", 0.0, 0.0),
      transmission("joint_compliance", 0.0, kLoss),
      {"thermal_drift",
       {{"depth", 0.5}, {"tau", 0.6}},
       [](const Block& b) { return b.drive(b.u) + 0.5 * (1.0 - std::exp(-b.t / 0.6)) * kDamping * b.v; }},
      {"armature", {{"J", 1.5}}, [](const Block& b) { return b.drive(b.u) * kBlockMass / (kBlockMass + 1.5); }},
      {"sensor_scale",
       {{"s", 0.1}},
       [](const Block& b) { return b.drive(b.u); },
       [](Block& b, double) { b.x /= 1.1; },
       nullptr,
       [](const Block& b) { return 1.1 * b.x; }},
      {"sensor_offset",
       {{"o", 0.05}},
       [](const Block& b) { return b.drive(b.u); },
       [](Block& b, double) { b.x -= 0.05; },
       nullptr,
       [](const Block& b) { return b.x + 0.05; }},
  };
  return all;
}

Drive commands() {
  Drive drive = constant_drive(1, 2.0, 0.01, 0.0);
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    // Steps every .25 s: kinks of the command fall on samples, and both directions come.
    const double steps[] = {1.0, -0.5, 2.0, -2.0, 0.3, 1.5, -1.0, 0.0, 0.0};
    drive.u[0][k] = steps[k / 25];
  }
  return drive;
}

std::vector<double> by_hand(const Law& law, const Drive& drive) {
  Block b;
  b.u = drive.u[0][0];
  if (law.begin) law.begin(b, 0.0);
  std::vector<double> out;
  const double fine = law.fine;
  const int pieces = static_cast<int>(std::lround(0.01 / law.fine));
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    out.push_back(law.reading ? law.reading(b) : b.x);
    b.u = drive.u[0][k];
    for (int i = 0; i < pieces; ++i) {
      // The midpoint rule on the motion; what is remembered follows it.
      Block half = b;
      half.x += 0.5 * fine * b.v;
      half.v += 0.5 * fine * law.force(b) / kBlockMass;
      half.t += 0.5 * fine;
      if (law.remember) law.remember(half, 0.5 * fine);
      b.x += fine * half.v;
      b.v += fine * law.force(half) / kBlockMass;
      b.t += fine;
      if (law.remember) law.remember(b, fine);
    }
  }
  return out;
}

Scenario driven_block(const Drive& drive) {
  return driven_scenario(
      block_robot(),
      {actuator("slide", "torque_source",
                {{"gain", kGain}, {"damping", kDamping}, {"stiffness", kStiffness}, {"rest", kRest}})},
      drive, kStart);
}

class CatalogueLaw : public testing::TestWithParam<std::size_t> {};

TEST_P(CatalogueLaw, MovesTheBlockAsTheEquationWrittenOutByHand) {
  const Law& law = laws()[GetParam()];
  const Drive drive = commands();
  const Scenario scenario = driven_block(drive);
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStart);
  const bool arm = effect_table()[find_effect(law.effect)].where == Where::arm;
  const std::string place = arm ? "arm" : "slide";
  const PlantModel model = plain.with_effects({effect(law.effect, place, law.parameters)});
  const std::vector<double> expected = by_hand(law, drive);
  double shows = 0.0;
  const auto without = predict_one(plain, experiment, on("featherstone", 0.001)).front()[0];
  for (std::size_t k = 0; k < expected.size(); ++k) shows = std::max(shows, std::fabs(without[k] - expected[k]));
  EXPECT_GT(shows, 1e-3) << "nothing was tested";
  for (const std::string& engine : available_engines()) {
    const auto got = predict_one(model, experiment, on(engine, 0.001)).front()[0];
    EXPECT_LT(worst_difference(got, expected), law.agreement) << law.effect << " on " << engine;
  }
}

INSTANTIATE_TEST_SUITE_P(All, CatalogueLaw, testing::Range(std::size_t{0}, laws().size()), [](const auto& p) {
  return std::string(laws()[p.param].effect) + "_" + std::to_string(p.param);
});

TEST(ActuatorLag, FarShorterThanTheStepActsByItsTime) {
  const Drive drive = commands();
  const Scenario scenario = driven_block(drive);
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStart);
  const auto moved = [&](double lag, double step) {
    return predict_one(plain.with_effects({effect("actuator_lag", "slide", {{"T", lag}})}), experiment,
                       on("featherstone", step))
        .front()[0];
  };
  const auto without = moved(0.0, 0.01);
  // Steps of a tenth of the lag at most leave nothing to ask of the parabola; the sampling period is the long step. A
  // thousandth: what a tenth of the noise is of an effect a hundred times the noise, the strongest that is looked for.
  for (const double lag : {2e-3, 5e-4, 1e-4}) {
    const auto fine = moved(lag, 0.1 * lag), coarse = moved(lag, 0.01);
    EXPECT_LT(worst_difference(coarse, fine), 1e-3 * worst_difference(without, fine)) << lag;
  }
  // And from there on in proportion, down to none.
  EXPECT_NEAR(worst_difference(moved(1e-8, 0.01), without) / worst_difference(moved(1e-6, 0.01), without), 1e-2, 1e-4);
}

TEST(Backlash, CarriesALoadAsStifflyAsItIsEvenWhereTheStepsCannotFollowItsContact) {
  constexpr double kGap = 0.002, kContact = 3000.0, kCommand = 0.5;  // rad, N m/rad, V
  const Scenario scenario =
      driven_scenario(bundled_robot("pendulum/pendulum.urdf"),
                      {actuator("swing", "torque_source",
                                {{"gain", kGain}, {"damping", 6.0}, {"stiffness", kStiffness}, {"rest", kRest}})},
                      constant_drive(1, 20.0, 0.02, kCommand), {{0.2}, {0.0}});
  const PlantModel model =
      PlantModel(scenario).with_effects({effect("backlash", "swing", {{"gap", kGap}, {"k", kContact}, {"J", 0.05}})});
  const double q =
      predict_one(model, started_experiment(scenario, {{0.2}, {0.0}}), on("featherstone", 0.02)).front()[0].back();
  const double load = 9.81 * 0.5 * std::sin(q);  // of the rod, N m
  // Steps of 20 ms follow no contact stiffer than .05 kg m^2 / (14 ms)^2 = 255 N m/rad.
  EXPECT_NEAR(kGain * kCommand - kStiffness * (q + kGap + load / kContact - kRest), load, 1e-6);
}

TEST(JointCompliance, TooStiffForTheStepsIsAnArmature) {
  // Damping and inertia as on a light elbow: the side's own time, J over damping, is far below what 20 ms samples show.
  const Drive drive = sine_drive(1, 10.0, 0.02, 3.0, 1.0);
  const Scenario scenario =
      driven_scenario(bundled_robot("pendulum/pendulum.urdf"),
                      {actuator("swing", "torque_source", {{"gain", 1.7}, {"damping", 0.6}, {"stiffness", 3.5}})},
                      drive, {{0.1}, {0.0}});
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, {{0.1}, {0.0}});
  const auto moved = [&](const EffectSpec& spec) {
    return predict_one(plain.with_effects({spec}), experiment, on("featherstone", 0.01)).front()[0];
  };
  const auto without = predict_one(plain, experiment, on("featherstone", 0.01)).front()[0];
  for (const double J : {1e-3, 1e-2, 1e-1}) {
    const auto rigid = moved(effect("armature", "swing", {{"J", J}}));
    const auto stiff = moved(effect("joint_compliance", "swing", {{"k", 1e8}, {"J", J}}));
    EXPECT_LT(worst_difference(stiff, rigid), 0.1 * worst_difference(rigid, without)) << J;
  }
}

TEST(SensorDelay, ShiftsTheReadingAndNothingElse) {
  const Drive drive = commands();
  const Scenario scenario = driven_block(drive);
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStart);
  const auto now = predict_one(plain, experiment, on("featherstone", 0.001)).front()[0];
  const auto late = predict_one(plain.with_effects({effect("sensor_delay", "slide", {{"T", 0.03}})}), experiment,
                                on("featherstone", 0.001))
                        .front()[0];
  for (std::size_t k = 3; k < now.size(); ++k) EXPECT_NEAR(late[k], now[k - 3], 1e-12);
}

TEST(SensorBacklash, StandsAfterAReversalByItsWidth) {
  const Drive drive = commands();
  const Scenario scenario = driven_block(drive);
  const PlantModel plain(scenario);
  const Experiment experiment = started_experiment(scenario, kStart);
  const auto true_motion = predict_one(plain, experiment, on("featherstone", 0.001)).front()[0];
  const auto reading = predict_one(plain.with_effects({effect("sensor_backlash", "slide", {{"h", 0.02}})}), experiment,
                                   on("featherstone", 0.001))
                           .front()[0];
  double past = true_motion[0];
  for (std::size_t k = 0; k < true_motion.size(); ++k) {
    past = played(past, true_motion[k], 0.02);
    EXPECT_NEAR(reading[k], past, 1e-14);
  }
}

TEST(BaseTilt, TurnsGravityAsARobotBuiltOnATiltedBaseFeelsIt) {
  const Scenario scenario = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {},
                                            constant_drive(2, 1.0, 0.01, 0.0), {{0.3, 0.2}, {0.0, 0.0}});
  Scenario tilted = scenario;
  const double roll = 0.1, pitch = -0.2;
  tilted.gravity = Eigen::AngleAxisd(-roll, Eigen::Vector3d::UnitX()) *
                   (Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitY()) * scenario.gravity);
  const Start start{{0.3, 0.2}, {0.0, 0.0}};
  const Experiment experiment = started_experiment(scenario, start);
  const PlantModel model =
      PlantModel(scenario).with_effects({effect("base_tilt", "arm", {{"roll", roll}, {"pitch", pitch}})});
  for (const std::string& engine : available_engines()) {
    EXPECT_LT(worst_difference(predict_one(model, experiment, on(engine, 0.002)).front()[1],
                               predict_one(PlantModel(tilted), experiment, on(engine, 0.002)).front()[1]),
              1e-12)
        << engine;
  }
}

TEST(EffortScale, ScalesTheEffortThatIsReadAndLeavesTheMotionAlone) {
  const Scenario scenario = driven_block(commands());
  Experiment experiment = started_experiment(scenario, kStart);
  experiment.channels.push_back(experiment.channels.front());
  experiment.channels.back().kind = ChannelKind::effort;
  for (Segment& segment : experiment.segments) segment.measured.push_back(segment.measured.front());
  const PlantModel plain(scenario), scaled = plain.with_effects({effect("effort_scale", "slide", {{"s", 0.1}})});
  const auto reading = [&](const PlantModel& model, bool true_machine) {
    TruthOptions options;
    options.settle = false;
    return true_machine ? simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options)
                        : predict_one(model, experiment, on("featherstone", 0.001)).front();
  };
  for (const bool true_machine : {false, true}) {
    const auto a = reading(plain, true_machine), b = reading(scaled, true_machine);
    EXPECT_TRUE(same_bits(a[0], b[0]));
    ASSERT_GT(std::fabs(a.back()[7]), 1.0) << "nothing was tested";
    for (std::size_t k = 0; k < a.back().size(); ++k) EXPECT_DOUBLE_EQ(b.back()[k], 1.1 * a.back()[k]);
  }
}

Inertial random_body(Noise& noise) {
  Eigen::Matrix3d axes, spread = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 9; ++i) axes(i / 3, i % 3) = noise();
  for (int i = 0; i < 3; ++i) spread(i, i) = 0.01 + noise.uniform();
  const Eigen::Matrix3d second = axes * spread * axes.transpose();
  return {0.5 + noise.uniform(), {noise(), noise(), noise()}, second.trace() * Eigen::Matrix3d::Identity() - second};
}

TEST(PseudoInertia, HoldsABodyWhole) {
  Noise noise(5);
  for (int k = 0; k < 20; ++k) {
    const Inertial body = random_body(noise), back = from_pseudo_inertia(pseudo_inertia(body));
    EXPECT_DOUBLE_EQ(back.mass, body.mass);
    EXPECT_TRUE(back.com.isApprox(body.com, 1e-14));
    EXPECT_TRUE(back.inertia.isApprox(body.inertia, 1e-12));
  }
}

/// Body of the double pendulum's elbow under rigid_body.
Inertial deformed(const std::map<std::string, double>& parameters) {
  const Scenario scenario = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {});
  const PlantModel model = PlantModel(scenario).with_effects({effect("rigid_body", "elbow", parameters)});
  return model.inertials(model.values())[1];
}

TEST(RigidBody, StaysOneThatMatterCanMake) {
  Noise noise(7);
  for (int k = 0; k < 50; ++k) {
    std::map<std::string, double> p;
    for (const char* name : {"alpha", "d1", "d2", "d3", "s12", "s23", "s13", "t1", "t2", "t3"}) p[name] = 0.5 * noise();
    const Inertial body = deformed(p);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> pseudo(pseudo_inertia(body));
    EXPECT_GT(pseudo.eigenvalues().minCoeff(), 0.0) << k;
    const Eigen::Vector3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia).eigenvalues();
    EXPECT_GT(axes(0) + axes(1), axes(2)) << "triangle inequality, " << k;
  }
}

TEST(RigidBody, ChangesWhatEachNumberIsNamedFor) {
  const Inertial plain = deformed({});
  const Inertial heavier = deformed({{"alpha", 0.3}});
  EXPECT_NEAR(heavier.mass, plain.mass * std::exp(0.6), 1e-14);
  EXPECT_TRUE(heavier.com.isApprox(plain.com, 1e-14));
  EXPECT_TRUE(heavier.inertia.isApprox(plain.inertia * std::exp(0.6), 1e-12));
  const Inertial shifted = deformed({{"t1", 0.01}, {"t2", -0.02}, {"t3", 0.03}});
  EXPECT_NEAR(shifted.mass, plain.mass, 1e-15);
  EXPECT_LT((shifted.com - plain.com - Eigen::Vector3d(0.01, -0.02, 0.03)).norm(), 1e-15);
  EXPECT_TRUE(shifted.inertia.isApprox(plain.inertia, 1e-12));
  // Stretched along y to twice its length: integral of y^2 dm fourfold, of z^2 dm as it was.
  const Inertial longer = deformed({{"d2", std::log(2.0)}});
  EXPECT_NEAR(longer.mass, plain.mass, 1e-15);
  EXPECT_NEAR(longer.com(1), 2.0 * plain.com(1), 1e-15);
  const auto along = [](const Inertial& b, int axis) { return 0.5 * b.inertia.trace() - b.inertia(axis, axis); };
  EXPECT_NEAR(along(longer, 1), 4.0 * along(plain, 1), 1e-14);
  EXPECT_NEAR(along(longer, 2), along(plain, 2), 1e-14);
}

TEST(RigidBody, IsMadeStrongerAsAWhole) {
  const EffectInfo& info = effect_table()[find_effect("rigid_body")];
  for (const ParameterInfo& p : info.parameters) EXPECT_DOUBLE_EQ(strengthened(info, p, 0.2, 0.5), 0.1) << p.name;
}

TEST(RigidBody, IsTheLinkItselfBeforeItCarriesAnything) {
  const Scenario scenario = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {});
  const EffectSpec body = effect("rigid_body", "elbow", {{"alpha", 0.2}, {"t1", 0.05}});
  const EffectSpec load = effect("payload", "arm", {{"m", 3.0}});
  const auto of = [&](const std::vector<EffectSpec>& effects) {
    const PlantModel model = PlantModel(scenario).with_effects(effects);
    return model.inertials(model.values())[1];
  };
  const Inertial one = of({body, load}), other = of({load, body}), alone = of({body});
  EXPECT_EQ(one.com, other.com);
  EXPECT_EQ(one.inertia, other.inertia);
  EXPECT_NEAR(one.mass, alone.mass + 3.0, 1e-14);
}

TEST(Payload, IsCarriedAtItsPlaceBesideTheTool) {
  const Scenario scenario = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {});
  const Robot::Tool& tool = scenario.robot->tool();
  const auto of = [&](const std::map<std::string, double>& p) {
    const PlantModel model = PlantModel(scenario).with_effects({effect("payload", "arm", p)});
    return model.inertials(model.values())[tool.body];
  };
  const Inertial plain = of({}), held = of({{"m", 2.0}, {"x", 0.1}, {"y", -0.2}, {"z", 0.3}});
  const Eigen::Vector3d place = tool.point + Eigen::Vector3d(0.1, -0.2, 0.3);
  EXPECT_DOUBLE_EQ(held.mass, plain.mass + 2.0);
  EXPECT_LT((held.mass * held.com - plain.mass * plain.com - 2.0 * place).norm(), 1e-14);
  EXPECT_EQ(of({{"x", 0.1}}).com, plain.com) << "a place without a mass";
}

TEST(ComShift, MovesTheCentreOfMassOfTheLinkBehindTheJoint) {
  const Scenario scenario = driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"), {},
                                            constant_drive(2, 1.0, 0.01, 0.0), {{0.3, 0.2}, {0.0, 0.0}});
  const PlantModel model =
      PlantModel(scenario).with_effects({effect("com_shift", "elbow", {{"dx", 0.01}, {"dy", -0.02}, {"dz", 0.03}})});
  const auto plain = PlantModel(scenario).inertials(PlantModel(scenario).values());
  const auto shifted = model.inertials(model.values());
  EXPECT_EQ(shifted[0].com, plain[0].com);
  EXPECT_LT((shifted[1].com - plain[1].com - Eigen::Vector3d(0.01, -0.02, 0.03)).norm(), 1e-15);
  EXPECT_EQ(shifted[1].inertia, plain[1].inertia);
}

}  // namespace
}  // namespace lacuna
