// The hydraulic actuator at one joint, against closed forms and an independent right-hand side.
#include <gtest/gtest.h>

#include <boost/numeric/odeint/integrate/integrate_times.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "tests/physics/hydraulic_plants.h"

namespace lacuna {
namespace {

using namespace test;
using namespace test::hydraulic;

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

TEST(Hydraulic, LeakageAsAnEffectLetsALoadCreepAtItsShareOfUnitSpeed) {
  const double creep = 5e5, push = -1500.0;  // N s/m, N
  const Start start{{0.0}, {push / creep}};
  const Drive closed = constant_drive(1, 2.0, 0.01, 0.0);
  const EffectSpec load = effect("torque_offset", "slide", {{"tau0", push}});
  const Moved run = simulated(
      driven(block_robot(), symmetric(), closed, start, {load, effect("leakage", "slide", {{"R", creep}})}), start);
  EXPECT_NEAR((run.q()[200] - run.q()[100]) / 1.0, push / creep, 1e-4 * std::fabs(push / creep));
  // The same as the actuator's own number.
  const Moved own =
      simulated(driven(block_robot(), symmetric({{"leakage", kArea * kArea / creep}}), closed, start, {load}), start);
  for (std::size_t k = 0; k < run.t.size(); ++k) ASSERT_NEAR(run.q()[k], own.q()[k], 1e-12) << run.t[k];
}

TEST(Hydraulic, ReliefAsAnEffectOpensAtTheLoadOfALoneChamber) {
  const Start start{{0.0}, {0.0}};
  const Drive closed = constant_drive(1, 0.2, 0.01, 0.0);
  const EffectSpec load = effect("torque_offset", "slide", {{"tau0", -6e4}});
  const auto run = [&](const Numbers& numbers, std::vector<EffectSpec> effects) {
    return simulated(driven(block_robot(), numbers, closed, start, std::move(effects)), start);
  };
  const Moved effect_of = run(symmetric(), {load, effect("relief", "slide", {{"most", 200 * kBar * kArea}})});
  const Moved own = run(symmetric({{"relief_pressure", 200 * kBar}}), {load}), none = run(symmetric(), {load});
  for (std::size_t k = 0; k < own.t.size(); ++k) ASSERT_NEAR(effect_of.q()[k], own.q()[k], 1e-9) << own.t[k];
  EXPECT_GT(std::fabs(own.q().back() - none.q().back()), 0.01) << "it opens at all";
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

TEST(Hydraulic, StartsWhereThePressuresAreMeasured) {
  const Start start{{0.0}, {0.0}};
  Scenario scenario = driven(block_robot(), cylinder(), constant_drive(1, 0.5, 0.01, 0.0), start);
  const Moved unknown = simulated(scenario, start);
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (double& p : data->columns[data->find("a_slide")]) p = 61 * kBar;
  for (double& p : data->columns[data->find("b_slide")]) p = 82 * kBar;
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

}  // namespace
}  // namespace lacuna
