// The hydraulic actuator against closed forms, an independent right-hand side and independent integrators.
#include <gtest/gtest.h>

#include <boost/numeric/odeint/integrate/integrate_times.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "physics/quantity.h"
#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;
using Numbers = std::map<std::string, double>;

constexpr double kStep = 0.005;         // s, that the mechanics alone would do with
constexpr double kTenthOfNoise = 5e-5;  // rad: of .0005, the positions' noise on the arm
constexpr double kLaminar = 2e5;        // Pa, below which an orifice is laminar
constexpr double kBar = 1e5;            // Pa

/// A balanced rotor of 2 kg m^2: no gravity acts on it.
constexpr double kInertia = 2.0;
std::shared_ptr<const Robot> rotor() {
  return Robot::from_urdf_text(R"(<robot name='rotor'><link name='world_link'/>
  <link name='rotor'><inertial><mass value='5'/><inertia ixx='1' iyy='1' izz='2' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='swing' type='continuous'><parent link='world_link'/><child link='rotor'/><axis xyz='0 0 1'/></joint></robot>)",
                               "rotor");
}

/// A cylinder of 40 and 20 mm with short hoses, without leaks.
Numbers cylinder() {
  return {{"gain", 5.7e-9},
          {"full_command", 10.0},
          {"area_a", 1.2566e-3},
          {"area_b", 9.425e-4},
          {"dead_volume_a", 4e-5},
          {"dead_volume_b", 3e-5},
          {"stroke", 0.2},
          {"bulk_modulus", 1.2e9},
          {"supply_pressure", 160 * kBar},
          {"return_pressure", 5 * kBar}};
}
Numbers with(Numbers numbers, const Numbers& changed) {
  for (const auto& [name, value] : changed) numbers[name] = value;
  return numbers;
}
/// Equal areas, about the middle of the stroke equal volumes: m^2, m^3.
constexpr double kArea = 1e-3, kVolume = 5e-5 + kArea * 0.1;
Numbers symmetric(const Numbers& changed = {}) {
  return with(
      with(cylinder(), {{"area_a", kArea}, {"area_b", kArea}, {"dead_volume_a", 5e-5}, {"dead_volume_b", 5e-5}}),
      changed);
}
const Numbers kLever = {{"lever_a", 0.30}, {"lever_b", 0.078}, {"lever_angle", 1.5}};

/// The scenario with efforts and both pressures measured at every joint.
Scenario measured_whole(Scenario scenario) {
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (const Joint& joint : scenario.robot->joints()) {
    for (const auto& [kind, prefix] :
         {std::pair{ChannelKind::effort, "e_"}, {ChannelKind::pressure_a, "a_"}, {ChannelKind::pressure_b, "b_"}}) {
      scenario.channels.of[kind][joint.name] = {prefix + joint.name, 1.0, 0.0, ""};
      data->names.push_back(prefix + joint.name);
      data->columns.emplace_back(data->rows(), kMissing);
    }
  }
  scenario.recordings[0].data = data;
  return scenario;
}

/// All channels of one joint by kind.
struct Moved {
  std::vector<double> t;
  std::map<ChannelKind, std::vector<double>> of;
  const std::vector<double>& q() const { return of.at(ChannelKind::position); }
  const std::vector<double>& v() const { return of.at(ChannelKind::velocity); }
  const std::vector<double>& a() const { return of.at(ChannelKind::pressure_a); }
  const std::vector<double>& b() const { return of.at(ChannelKind::pressure_b); }
  const std::vector<double>& effort() const { return of.at(ChannelKind::effort); }
};
Scenario driven(std::shared_ptr<const Robot> robot, const Numbers& numbers, const Drive& drive, const Start& start,
                std::vector<EffectSpec> effects = {}) {
  const std::string joint = robot->joints()[0].name;
  Scenario out = driven_scenario(std::move(robot), {actuator(joint, "hydraulic", numbers)}, drive, start);
  out.effects = std::move(effects);
  return measured_whole(std::move(out));
}
Moved simulated(const Scenario& scenario, const Start& start, double step = kStep,
                const std::string& engine = "featherstone") {
  const Experiment experiment = started_experiment(scenario, start);
  const auto predicted = predict_one(PlantModel(scenario), experiment, on(engine, step)).front();
  Moved out{experiment.segments[0].commands->time, {}};
  for (std::size_t c = 0; c < predicted.size(); ++c) out.of[experiment.channels[c].kind] = predicted[c];
  return out;
}
/// A friction that nothing overcomes.
EffectSpec blocked(const std::string& joint) { return effect("coulomb_friction", joint, {{"Fc", 1e8}}); }

TEST(Hydraulic, FillsAClosedChamberAsTheRootOfTheDropFalls) {
  const Numbers numbers = symmetric();
  const double u = 0.1, rate = 5.7e-9 * (u / 10.0) * 1.2e9 / kVolume;  // Pa^0.5/s
  const Start start{{0.0}, {0.0}};
  const Moved run =
      simulated(driven(block_robot(), numbers, constant_drive(1, 2.0, 0.01, u), start, {blocked("slide")}), start);
  const double p0 = 0.5 * (160 + 5) * kBar;
  ASSERT_NEAR(run.a()[0], p0, 1.0);
  int compared = 0;
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const double root = std::sqrt(160 * kBar - p0) - 0.5 * rate * run.t[k], drop = root * root;
    if (root < 0.0 || drop < 20 * kBar) break;
    // Laminar flow falls short of the root's by at most this share.
    const double less = 0.25 * std::pow(kLaminar / drop, 2), lag = root * rate * run.t[k] * less;
    EXPECT_LE(run.a()[k], 160 * kBar - drop + 1.0) << run.t[k];
    EXPECT_GE(run.a()[k], 160 * kBar - drop - lag - 1.0) << run.t[k];
    EXPECT_NEAR(run.a()[k] + run.b()[k], 165 * kBar, 1.0) << "equal chambers mirror each other";
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

TEST(Hydraulic, RingsAtTheFrequencyOfItsOil) {
  // On a lever away from the middle, so that arm and volumes are all other than at rest.
  const Start start{{0.2}, {1e-3}};
  const Moved run =
      simulated(driven(rotor(), with(cylinder(), kLever), constant_drive(1, 1.0, 0.01, 0.0), start), start);
  const double a = 0.30, b = 0.078;
  const auto length = [&](double q) { return std::sqrt(a * a + b * b - 2.0 * a * b * std::cos(q + 1.5)); };
  const double arm = a * b * std::sin(1.7) / length(0.2), out = length(0.2) - length(0.0);
  const double volume_a = 4e-5 + 1.2566e-3 * (0.1 + out), volume_b = 3e-5 + 9.425e-4 * (0.1 - out);
  const double k = 1.2e9 * (1.2566e-3 * 1.2566e-3 / volume_a + 9.425e-4 * 9.425e-4 / volume_b) * arm * arm;
  const double omega = std::sqrt(k / kInertia), amplitude = 1e-3 / omega;
  EXPECT_GT(omega * kStep, 0.2) << "too slow to test what is fast";
  EXPECT_GT(omega, 2.0 * std::numbers::pi * 10.0) << "ten periods";
  // Arm and volumes change by some 1e-4 of themselves along it, the frequency by less, over 100 rad.
  for (std::size_t i = 0; i < run.t.size(); ++i)
    ASSERT_NEAR(run.q()[i] - 0.2, amplitude * std::sin(omega * run.t[i]), 5e-3 * amplitude) << run.t[i];
}

TEST(Hydraulic, LeakageDampsTheRinging) {
  const double leak = 2e-12, fades = 1.2e9 * leak / kVolume;  // 1/s
  const double omega = std::sqrt(2.0 * 1.2e9 * kArea * kArea / kVolume / kBlockMass);
  const double rings = std::sqrt(omega * omega - fades * fades);
  EXPECT_GT(fades, 10.0);
  const Start start{{0.0}, {1e-3}};
  const Moved run =
      simulated(driven(block_robot(), symmetric({{"leakage", leak}}), constant_drive(1, 0.3, 0.01, 0.0), start), start);
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const double t = run.t[i], envelope = 1e-3 * std::exp(-fades * t);
    // Every 1.6 rad of what is so much faster than the steps are carried to 2e-4 (physics/fast_motion.h).
    ASSERT_NEAR(run.v()[i], envelope * (std::cos(rings * t) + fades / rings * std::sin(rings * t)),
                (2e-4 / 1.6 * omega * t + 1e-6) * envelope)
        << t;
  }
}

TEST(Hydraulic, StallsAtTheSupplyAndDoesNotWindUp) {
  const Start start{{0.0}, {0.0}};
  Drive drive = constant_drive(1, 20.0, 0.01, 10.0);
  for (std::size_t k = 1001; k < drive.time.size(); ++k) drive.u[0][k] = -10.0;
  const Moved run = simulated(driven(block_robot(), cylinder(), drive, start, {blocked("slide")}), start);
  const double up = (160 * 1.2566e-3 - 5 * 9.425e-4) * kBar, down = (5 * 1.2566e-3 - 160 * 9.425e-4) * kBar;
  for (const std::size_t k : {std::size_t{100}, std::size_t{1000}}) {
    EXPECT_NEAR(run.a()[k], 160 * kBar, 1.0);
    EXPECT_NEAR(run.b()[k], 5 * kBar, 1.0);
    EXPECT_NEAR(run.effort()[k], up, 1e-2);
  }
  // What ten seconds pressed in comes out in less than one.
  EXPECT_NEAR(run.effort()[1100], down, 1e-2);
  EXPECT_NEAR(run.effort().back(), down, 1e-2);
  for (const double p : run.a()) EXPECT_TRUE(p > 0.0 && p < 160.5 * kBar) << p;
  EXPECT_EQ(run.q().back(), 0.0);
}

TEST(Hydraulic, ReliefAndVacuumBoundWhatALoadPressesInto) {
  // Valve closed, the load presses the piston with more than the relief valve holds, then pulls.
  for (const double push : {-6e4, 6e4}) {
    const Start start{{0.0}, {0.0}};
    const Moved run =
        simulated(driven(block_robot(), symmetric({{"relief_pressure", 200 * kBar}}), constant_drive(1, 0.2, 0.01, 0.0),
                         start, {effect("torque_offset", "slide", {{"tau0", push}})}),
                  start);
    const auto [low, high] = std::minmax_element(run.a().begin(), run.a().end());
    // A force of 600 bar times the area: it overruns the relief valve, whose flow grows with the pressure alone.
    if (push < 0.0) {
      EXPECT_GT(*high, 200 * kBar);
    }
    if (push > 0.0) {
      EXPECT_LT(*low, 1 * kBar);
    }
    EXPECT_GT(std::fabs(run.q().back()), 0.01) << "the load passes";
    EXPECT_TRUE(std::isfinite(run.q().back()));
  }
}

constexpr double kRubs = 200.0;  // N s/m: lets the start's ringing fade

/// m/s under a constant command against `load` (N, against the motion up): both edges' drops and the force in balance.
double closed_speed(const Numbers& n, double u, double load, double& least_drop, double rubs = kRubs) {
  const double k = n.at("gain") * std::fabs(u) / n.at("full_command"), a = n.at("area_a"), b = n.at("area_b");
  const double high = n.at("supply_pressure"), low = n.at("return_pressure"), cubes = a * a * a + b * b * b;
  double speed = 0.0;  // what rubs against it is a small part of the balance
  for (int round = 0; round < 20; ++round) {
    const double drive = u > 0.0 ? high * a - low * b - load : high * b - low * a + load;
    speed = k * std::sqrt((drive - rubs * speed) / cubes);
  }
  least_drop = std::pow(std::min(a, b) * speed / k, 2);
  return u > 0.0 ? speed : -speed;
}

TEST(Hydraulic, MovesAtTheSpeedOfItsTwoEdges) {
  const Numbers numbers = cylinder();
  for (const double load : {0.0, 6000.0, -4000.0}) {
    for (const double u : {10.0, 6.0, -6.0, -10.0}) {
      const Start start{{0.0}, {0.0}};
      const Moved run = simulated(driven(block_robot(), numbers, constant_drive(1, 4.0, 0.01, u), start,
                                         {effect("torque_offset", "slide", {{"tau0", -load}}),
                                          effect("viscous_friction", "slide", {{"D", kRubs}})}),
                                  start);
      double drop = 0.0;
      const double speed = closed_speed(numbers, u, load, drop);
      EXPECT_NEAR(run.v().back(), speed, 0.3 * std::pow(kLaminar / drop, 2) * std::fabs(speed)) << u << ' ' << load;
    }
  }
}

TEST(Hydraulic, ACommandBeyondFullOpensNoFurther) {
  const Start start{{0.0}, {0.0}};
  const auto run = [&](double u) {
    return simulated(driven(block_robot(), cylinder(), constant_drive(1, 0.5, 0.01, u), start), start).q();
  };
  EXPECT_TRUE(same_bits(run(10.0), run(25.0)));
  EXPECT_FALSE(same_bits(run(10.0), run(9.0)));
}

/// J that the pump put in, less what flowed to the return, and J of work on the joint, up to the last sample.
std::pair<double, double> energies(const Moved& run, const Drive& drive, const Numbers& n) {
  double given = 0.0, done = 0.0, before_given = 0.0, before_done = 0.0;
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const auto flow = [&](double drop) { return drop / std::pow(drop * drop + kLaminar * kLaminar, 0.25); };
    const double wide = n.at("gain") * std::fabs(drive.u[0][k]) / n.at("full_command");
    const bool up = drive.u[0][k] > 0.0;
    const double high = n.at("supply_pressure"), low = n.at("return_pressure");
    const double in = wide * flow(high - (up ? run.a() : run.b())[k]),
                 out = wide * flow((up ? run.b() : run.a())[k] - low);
    const double power_given = high * in - low * out, power_done = run.effort()[k] * run.v()[k];
    const double dt = k > 0 ? run.t[k] - run.t[k - 1] : 0.0;
    given += 0.5 * dt * (power_given + before_given), done += 0.5 * dt * (power_done + before_done);
    before_given = power_given, before_done = power_done;
  }
  return {given, done};
}

TEST(Hydraulic, DoesNoMoreWorkThanTheSupplyPutsIn) {
  const Numbers numbers = cylinder();
  const Drive drive = sine_drive(1, 6.0, 0.0005, 10.0);
  // J: half of the compressed oil's pressure times the volume it gave way by, at most, in both chambers.
  const double stored = 0.5 * std::pow(200 * kBar, 2) * (2e-3 * 0.2 + 7e-5) / 1.2e9;
  for (const double load : {0.0, -8000.0, 8000.0}) {
    const Start start{{0.0}, {0.0}};
    const Moved run = simulated(
        driven(block_robot(), numbers, drive, start, {effect("torque_offset", "slide", {{"tau0", load}})}), start);
    const auto [given, done] = energies(run, drive, numbers);
    EXPECT_LT(done, given + stored) << load;
    EXPECT_GT(given, 5.0 * stored) << "too little to tell";
  }
}

TEST(Hydraulic, IsAFlowSourceWhereOilIsStiffAndNothingLoadsIt) {
  // Equal areas: each edge takes half of the pressure, and the speed is gain u / full f(dp) / area.
  const double drop = 0.5 * (160 - 5) * kBar, flow = drop / std::pow(drop * drop + kLaminar * kLaminar, 0.25);
  const Drive drive = sine_drive(1, 3.0, 0.01, 8.0);
  const Start start{{0.0}, {0.0}};
  const Scenario plain =
      driven_scenario(block_robot(),
                      {actuator("slide", "flow_source",
                                {{"gain", 5.7e-9 / 10.0 * flow / kArea}, {"stiffness", 4e6}, {"damping", 4e3}})},
                      drive, start);
  const auto source =
      predict_one(PlantModel(plain), started_experiment(plain, start), on("featherstone", 2.5e-4)).front();
  double before = 0.0;
  for (const double bulk : {1e9, 1e10}) {
    const Moved run = simulated(driven(block_robot(), symmetric({{"bulk_modulus", bulk}}), drive, start), start);
    const double range = *std::max_element(run.q().begin(), run.q().end());
    const double off = worst_difference(run.q(), source[0]);
    EXPECT_GT(range, 5e-3);
    EXPECT_LT(off, 3e-3 * range) << bulk;
    if (before > 0.0) {
      EXPECT_LT(off, 0.5 * before) << "no limit";
    }
    before = off;
  }
}

TEST(Hydraulic, HoldsItsLoadWithBothPressuresBetweenReturnAndSupply) {
  for (const double q : {-1.2, 0.3, 1.4}) {
    const Start start{{q}, {0.0}};
    const Moved run = simulated(driven(bundled_robot("pendulum/pendulum.urdf"), with(cylinder(), {{"ratio", 0.02}}),
                                       constant_drive(1, 0.5, 0.01, 0.0), start),
                                start);
    for (const double p : {run.a()[0], run.b()[0]}) EXPECT_TRUE(p >= 5 * kBar && p <= 160 * kBar) << p;
    EXPECT_NEAR(run.effort()[0], 9.81 * 0.5 * std::sin(q), 1e-6);
    for (const double later : run.q()) ASSERT_NEAR(later, q, 1e-9);
  }
}

TEST(Hydraulic, StartedInSteadyMotionItGoesOn) {
  // What a window starts from: position and speed, and pressures that nobody measured.
  double drop = 0.0;
  const double speed = closed_speed(cylinder(), 8.0, 0.0, drop, 0.0);
  const Start start{{0.0}, {speed}};
  const Moved run = simulated(driven(block_robot(), cylinder(), constant_drive(1, 1.0, 0.01, 8.0), start), start);
  for (const double v : run.v()) ASSERT_NEAR(v, speed, 1e-3 * speed);
}

// --- The same physics written down a second time, in bar, for one pendulum on a lever. ---
namespace odeint = boost::numeric::odeint;
using Vector = std::vector<double>;

/// q, v, p_A, p_B (rad, rad/s, bar) of the bundled pendulum on the cylinder of the test below.
struct PendulumOnACylinder {
  double inertia, moment;  // kg m^2, N m: about the pin, of the weight
  double command = 0.0;

  static double root(double drop) { return drop / std::pow(drop * drop + 4.0, 0.25); }  // bar^0.5
  void operator()(const Vector& x, Vector& rate, double) const {
    const double phi = x[0] + 1.5, length = std::sqrt(0.09 + 0.006084 - 0.0468 * std::cos(phi));
    const double arm = 0.0234 * std::sin(phi) / length, middle = std::sqrt(0.09 + 0.006084 - 0.0468 * std::cos(1.5));
    const double a = 2e-4, b = 1.4e-4, bulk = 1.2e4, leak = 5e-10;  // m^2, bar, m^3/(s bar)
    const double volume_a = 4e-5 + a * (0.1 + length - middle), volume_b = 3e-5 + b * (0.1 - length + middle);
    const double open = std::clamp(command / 10.0, -1.0, 1.0) * 2e-9 * std::sqrt(1e5);  // m^3/(s bar^0.5)
    const double in_a = open > 0.0 ? open * root(160.0 - x[2]) : open * root(x[2] - 5.0);
    const double out_b = open > 0.0 ? open * root(x[3] - 5.0) : open * root(160.0 - x[3]);
    rate[0] = x[1];
    rate[1] = ((a * x[2] - b * x[3]) * 1e5 * arm - moment * std::sin(x[0])) / inertia;
    rate[2] = bulk / volume_a * (in_a - a * arm * x[1] - leak * (x[2] - x[3]));
    rate[3] = bulk / volume_b * (-out_b + b * arm * x[1] + leak * (x[2] - x[3]));
  }
};
/// [sample]: q, from the pressures at which `run` starts, commands held from sample to sample.
std::vector<double> by_fehlberg(PendulumOnACylinder plant, const Moved& run, const Drive& drive) {
  Vector x{run.q()[0], run.v()[0], run.a()[0] / kBar, run.b()[0] / kBar};
  std::vector<double> out{x[0]};
  for (std::size_t k = 0; k + 1 < drive.time.size(); ++k) {
    plant.command = drive.u[0][k];
    const std::vector<double> ends{drive.time[k], drive.time[k + 1]};
    odeint::integrate_times(odeint::make_controlled(1e-12, 1e-12, odeint::runge_kutta_fehlberg78<Vector>()), plant, x,
                            ends, 1e-5, [](const Vector&, double) {});
    out.push_back(x[0]);
  }
  return out;
}

TEST(Hydraulic, IsTheSamePhysicsAsARightHandSideWrittenApart) {
  const Numbers numbers =
      with(with(cylinder(), kLever), {{"gain", 2e-9}, {"area_a", 2e-4}, {"area_b", 1.4e-4}, {"leakage", 5e-10 / kBar}});
  Drive drive = sine_drive(1, 3.0, 0.01, 8.0);
  for (std::size_t k = 100; k < 160; ++k) drive.u[0][k] = k < 130 ? 10.0 : 0.0;  // and jumps
  const auto robot = bundled_robot("pendulum/pendulum.urdf");
  const Start start{{0.3}, {0.0}};
  const Scenario scenario = driven(robot, numbers, drive, start);
  const auto engine = find_engine("featherstone").build(robot, scenario.gravity);
  Eigen::MatrixXd mass;
  engine->mass_matrix(std::vector<double>{0.0}, mass);
  const Moved coarse = simulated(scenario, start);
  const auto reference = by_fehlberg({mass(0, 0), 9.81 * 0.5}, coarse, drive);
  const auto [low, high] = std::minmax_element(reference.begin(), reference.end());
  EXPECT_GT(*high - *low, 0.1);
  EXPECT_LT(worst_difference(coarse.q(), reference), kTenthOfNoise);
  EXPECT_LT(worst_difference(simulated(scenario, start, 2.5e-4).q(), reference), 1e-8);
}

// --- The whole arm. ---
Numbers arm_joint(const Numbers& own) {
  const double dead = own.at("dead");
  Numbers out{{"full_command", 10.0},          {"dead_volume_a", dead},
              {"dead_volume_b", dead},         {"hose_compliance", 1 / 1.5e8},
              {"supply_pressure", 160 * kBar}, {"return_pressure", 5 * kBar},
              {"relief_pressure", 200 * kBar}, {"leakage", 5e-14}};
  for (const auto& [name, value] : own)
    if (name != "dead") out[name] = value;
  return out;
}
Numbers rotary(double gain, double displacement, double dead, double range) {
  return arm_joint(
      {{"gain", gain}, {"area_a", displacement}, {"area_b", displacement}, {"dead", dead}, {"stroke", range}});
}
Numbers on_lever(double gain, double bore, double rod, double dead, double stroke, const Numbers& lever) {
  const double quarter = std::numbers::pi / 4.0;
  Numbers out = arm_joint({{"gain", gain},
                           {"area_a", quarter * bore * bore},
                           {"area_b", quarter * (bore * bore - rod * rod)},
                           {"dead", dead},
                           {"stroke", stroke}});
  return with(out, lever);
}
/// Six joints of plausible size: oil rings at 4 to 80 Hz, hardly damped at the wrist. `hoses`: share of their volume.
Scenario hydraulic_arm(const Drive& drive, const Start& start, double hoses = 1.0) {
  const std::vector<Numbers> joints = {
      rotary(5e-9, 40e-6, 25e-6 * hoses, 2.2),
      on_lever(5.7e-9, 0.040, 0.020, 28e-6 * hoses, 0.134,
               {{"lever_a", 0.30}, {"lever_b", 0.078}, {"lever_angle", 1.0472}, {"middle", 0.52}}),
      on_lever(4.3e-9, 0.032, 0.016, 25e-6 * hoses, 0.105,
               {{"lever_a", 0.24}, {"lever_b", 0.060}, {"lever_angle", 2.3562}, {"middle", -0.83}}),
      rotary(4.2e-9, 20e-6, 20e-6 * hoses, 5.0),
      on_lever(3.0e-9, 0.025, 0.012, 22e-6 * hoses, 0.068,
               {{"lever_a", 0.15}, {"lever_b", 0.040}, {"lever_angle", 1.4835}}),
      rotary(4.2e-9, 8e-6, 20e-6 * hoses, 20.0)};
  std::vector<ActuatorSpec> actuators;
  for (std::size_t j = 0; j < joints.size(); ++j)
    actuators.push_back(actuator("joint_" + std::to_string(j + 1), "hydraulic", joints[j]));
  return driven_scenario(bundled_robot("hydrolek/seed_table1.urdf"), actuators, drive, start);
}
const Start kArmStart{{0.2, 0.4, -0.8, 0.3, 0.2, 0.1}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, false};

/// Jumps every .2 to .8 s, a third of them to a closed valve.
Drive jumps(double seconds, double amplitude) {
  Drive out{clock(seconds, 0.01), {}};
  Noise random(5);
  for (int j = 0; j < 6; ++j) {
    std::vector<double> u;
    double now = 0.0;
    for (int left = 10; u.size() < out.time.size(); --left) {
      if (left == 0) {
        now = random.uniform() < 0.3 ? 0.0 : (now > 0.0 ? -1.0 : 1.0) * amplitude * random.uniform();
        left = 20 + static_cast<int>(60.0 * random.uniform());
      }
      u.push_back(now);
    }
    out.u.push_back(std::move(u));
  }
  return out;
}

std::vector<std::vector<double>> reference_of(const PlantModel& model, const Experiment& experiment) {
  TruthOptions options;
  options.extended_precision = true;
  options.tolerance = 1e-11;
  return simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
}
double worst_of(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b,
                std::size_t channels) {
  double worst = 0.0;
  for (std::size_t c = 0; c < channels; ++c) worst = std::max(worst, worst_difference(a[c], b[c]));
  return worst;
}

TEST(HydraulicArm, MeetsAnIndependentIntegratorAtTheMechanicsOwnStep) {
  for (const bool jumping : {false, true}) {
    const Drive drive = jumping ? jumps(2.0, 6.0) : sine_drive(6, 2.0, 0.01, 8.0);
    const Scenario scenario = hydraulic_arm(drive, kArmStart);
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, kArmStart);
    const auto reference = reference_of(model, experiment);
    const auto moved = [&](double step) { return predict_one(model, experiment, on("featherstone", step)).front(); };
    EXPECT_LT(worst_of(moved(kStep), reference, 6), kTenthOfNoise) << jumping;
    // An eighth of the step leaves a thousandth: above third order.
    EXPECT_LT(worst_of(moved(6.25e-4), reference, 6), 2e-8) << jumping;
    for (std::size_t j = 0; j < 6; ++j) {
      const auto [low, high] = std::minmax_element(reference[j].begin(), reference[j].end());
      EXPECT_GT(*high - *low, 0.01) << "joint " << j + 1 << " hardly moves";
    }
  }
}

TEST(HydraulicArm, WithoutHosesIsFasterStillAndMeetsItToo) {
  const Scenario scenario = hydraulic_arm(sine_drive(6, 2.0, 0.01, 8.0), kArmStart, 0.05);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  EXPECT_LT(
      worst_of(predict_one(model, experiment, on("featherstone", kStep)).front(), reference_of(model, experiment), 6),
      kTenthOfNoise);
}

/// rms over the channels' samples of the worst channel.
double worst_rms(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b) {
  double worst = 0.0;
  for (std::size_t c = 0; c < a.size(); ++c) {
    double sum = 0.0;
    for (std::size_t k = 0; k < a[c].size(); ++k) sum += std::pow(a[c][k] - b[c][k], 2);
    worst = std::max(worst, std::sqrt(sum / static_cast<double>(a[c].size())));
  }
  return worst;
}

TEST(HydraulicArm, SticksAndSlidesAsTheIndependentIntegratorHasIt) {
  Scenario scenario = hydraulic_arm(jumps(2.0, 6.0), kArmStart);
  for (const Joint& joint : scenario.robot->joints())
    scenario.noise[ChannelKind::position][joint.name] = 10.0 * kTenthOfNoise;
  scenario.effects = {effect("coulomb_friction", "joint_2", {{"Fc", 60.0}}),
                      effect("coulomb_friction", "joint_3", {{"Fc", 30.0}})};
  const auto differ = [&](double step) {
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, kArmStart);
    if (step == 0.0) step = choose_step(model, experiment, on("featherstone", 0.01), model.values()).step;
    return worst_rms(predict_one(model, experiment, on("featherstone", step)).front(), reference_of(model, experiment));
  };
  EXPECT_LT(differ(kStep), kTenthOfNoise);
  // A wrist that sticks rings through several reversals in a step; which one holds it takes a shorter one to see.
  scenario.effects.push_back(effect("coulomb_friction", "joint_4", {{"Fc", 2.0}}));
  EXPECT_LT(differ(0.0), kTenthOfNoise);
}

TEST(Hydraulic, StaysStableFarBelowTheStep) {
  // The block of 2 kg rings at some 450 Hz: fourteen radians in a step.
  const Drive drive = sine_drive(1, 3.0, 0.01, 8.0);
  const Start start{{0.0}, {0.0}};
  const Scenario scenario = driven(block_robot(), symmetric({{"leakage", 1e-13}}), drive, start);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, start);
  const auto reference = reference_of(model, experiment);
  const auto moved = predict_one(model, experiment, on("featherstone", kStep)).front();
  EXPECT_GT(*std::max_element(reference[0].begin(), reference[0].end()), 0.005);
  EXPECT_LT(worst_difference(moved[0], reference[0]), 5e-6);  // m: a thousandth of the way
}

TEST(HydraulicArm, IsTheSameOnEveryEngine) {
  const Scenario scenario = hydraulic_arm(jumps(1.0, 6.0), kArmStart);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto ours = predict_one(model, experiment, on("featherstone", kStep)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(model, experiment, on(engine, kStep)).front();
    // ODE's accelerations are derived from a tiny step.
    EXPECT_LT(worst_of(other, ours, 6), engine == "ode" ? 1e-6 : 1e-9) << engine;
  }
}

TEST(HydraulicArm, HasTheSameBitsInAnyCompanyAndOnAnyNumberOfThreads) {
  const Scenario scenario = hydraulic_arm(jumps(0.5, 6.0), kArmStart);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  Noise random(3);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(lane_info().width) + 3, model.values());
  for (auto& individual : values)
    for (double& x : individual) x *= 0.8 + 0.4 * random.uniform();
  values[1][static_cast<std::size_t>(model.find("joint_4.bulk_modulus"))] *= 30.0;  // needs many more pieces
  const auto together = predict(model, experiment, values, on("featherstone", kStep));
  EXPECT_TRUE(same_bits(together, predict(model, experiment, values, on("featherstone", kStep, 2))));
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}, values.size() - 1})
    EXPECT_TRUE(same_bits(predict(model, experiment, {values[i]}, on("featherstone", kStep))[0], together[i])) << i;
  for (std::size_t i = 0; i < values.size(); ++i) {
    auto scalar = make_engine_predictor("featherstone", model, experiment);
    const std::vector<LaneTask> one{{&values[i], &experiment.segments[0]}};
    std::vector<std::vector<std::vector<double>>> expected;
    scalar->predict(one, kStep, expected);
    EXPECT_LT(worst_of(together[i][0], expected[0], 6), 1e-9) << i;
  }
}

TEST(HydraulicArm, PressuresAreComparedOnlyWhereThereAreChambersAndMotionsAreSimulated) {
  Scenario scenario = measured_whole(hydraulic_arm(jumps(1.0, 6.0), kArmStart));
  scenario.actuators[1] = actuator("joint_2", "torque_source", {{"gain", 1.0}, {"damping", 1.0}, {"stiffness", 1.0}});
  scenario.noise[ChannelKind::pressure_a]["joint_1"] = 2e4;
  const auto compared = [](const Scenario& of) {
    std::map<ChannelKind, std::vector<int>> out;
    for (const Channel& channel : make_experiment(of).channels) out[channel.kind].push_back(channel.joint);
    return out;
  };
  const std::vector<int> all{0, 2, 3, 4, 5};
  EXPECT_EQ(compared(scenario)[ChannelKind::pressure_a], all);
  EXPECT_EQ(compared(scenario)[ChannelKind::pressure_b], all);
  for (const Channel& channel : make_experiment(scenario).channels) {
    if (channel.kind != ChannelKind::pressure_a) continue;
    EXPECT_EQ(channel.noise_stated, channel.joint == 0);
    if (channel.joint == 0) {
      EXPECT_EQ(channel.noise, 2e4);
    }
  }
  scenario.prediction = InverseDynamics{10.0};
  EXPECT_TRUE(compared(scenario)[ChannelKind::pressure_a].empty());
  EXPECT_EQ(compared(scenario)[ChannelKind::effort].size(), 6u);
}

TEST(Hydraulic, StartsWhereThePressuresAreMeasured) {
  const Start start{{0.0}, {0.0}};
  Scenario scenario = driven(block_robot(), cylinder(), constant_drive(1, 0.5, 0.01, 0.0), start);
  const Moved unknown = simulated(scenario, start);
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (double& p : data->columns[static_cast<std::size_t>(data->find("a_slide"))]) p = 61 * kBar;
  for (double& p : data->columns[static_cast<std::size_t>(data->find("b_slide"))]) p = 82 * kBar;
  scenario.recordings[0].data = data;
  const Moved known = simulated(scenario, start);
  EXPECT_NEAR(known.a()[0], 61 * kBar, 1.0);
  EXPECT_NEAR(known.b()[0], 82 * kBar, 1.0);
  EXPECT_GT(std::fabs(unknown.a()[0] - 61 * kBar), kBar);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, start);
  const auto reference = reference_of(model, experiment);
  for (std::size_t c = 0; c < reference.size(); ++c)
    if (experiment.channels[c].kind == ChannelKind::pressure_b) {
      EXPECT_NEAR(reference[c][0], 82 * kBar, 1.0);
    }
}

TEST(HydraulicArm, PressuresAreThoseOfTheIndependentIntegrator) {
  Scenario scenario = measured_whole(hydraulic_arm(jumps(1.0, 6.0), kArmStart));
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  ASSERT_EQ(experiment.channels.size(), 24u);
  const auto moved = predict_one(model, experiment, on("featherstone", kStep)).front();
  const auto reference = reference_of(model, experiment);
  for (std::size_t c = 0; c < moved.size(); ++c) {
    if (quantity_of(experiment.channels[c].kind).predicted_by != PredictedBy::chambers) continue;
    EXPECT_EQ(experiment.channels[c].unit, "Pa");
    const auto [low, high] = std::minmax_element(reference[c].begin(), reference[c].end());
    EXPECT_GT(*high - *low, kBar);
    EXPECT_LT(worst_difference(moved[c], reference[c]), 0.02 * kBar) << "channel " << c;
  }
}

}  // namespace
}  // namespace lacuna
