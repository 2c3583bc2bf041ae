// What every engine of the registry must do, whatever its method.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>
#include <thread>

#include "backends/registry.h"
#include "scenarios/error.h"
#include "tests/conformance/motion.h"
#include "tests/conformance/random_robot.h"
#include "tests/conformance/worst.h"
#include "tests/reference/cartpole.h"
#include "tests/reference/double_pendulum.h"
#include "tests/reference/pendulum.h"

namespace lacuna::test {
namespace {

using Eigen::Vector2d;
using Numbers = std::vector<double>;

/// Acceleration difference over the acceleration's norm: rounding, 1e-16, times the condition of a 30-joint mass
/// matrix, up to 1e5, with two decades to spare. ODE, of which 1e-5 is asked, has rounding only as well (derived in
/// its source), times the condition of all joint constraints together.
constexpr double acceleration_tolerance = 1e-9;

/// ODE lends a point mass a least inertia of 1e-8 of what it has about its frame, in three directions.
constexpr double ode_point_mass_tolerance = 1e-7;

/// m, and entries of rotation matrices: a chain of 30 multiplies 30 roundings.
constexpr double pose_tolerance = 1e-9;

/// Order of each native integrator; 0: not expected to converge as the step shrinks.
const std::map<std::string, int> native_orders = {
    {"semi_implicit_euler", 1},  // featherstone, bullet, dart
    {"rk4", 4},                  // featherstone, mujoco, bullet
    {"euler", 1},
    {"implicit", 1},  // mujoco
    {"runge_kutta_merson", 4},
    {"runge_kutta_feldberg", 4},
    {"runge_kutta_3", 3},
    {"semi_explicit_euler", 1},
    {"explicit_euler", 1},  // simbody
    {"step", 1},
    {"quickstep", 0},  // ode; quickstep stops its iteration early at any step
};

const Eigen::Vector3d earth(0, 0, -9.81);
const Eigen::Vector3d slanted(1.3, -2.1, -9.0);

double difference(const Numbers& a, const Numbers& b) {
  const Eigen::Map<const Eigen::VectorXd> x(a.data(), a.size());
  const Eigen::Map<const Eigen::VectorXd> y(b.data(), b.size());
  return (x - y).norm();
}
double norm(const Numbers& a) { return difference(a, Numbers(a.size(), 0.0)); }

std::vector<std::string> engine_names() {
  std::vector<std::string> names;
  for (const Engine* engine : engines()) names.push_back(engine->info().name);
  return names;
}

Numbers acceleration(Dynamics& dynamics, const State& state) {
  Numbers a(state.q.size());
  dynamics.forward_dynamics(state.q, state.v, state.tau, a);
  return a;
}

class EngineConformance : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const EngineInfo info = engine().info();
    if (!info.available) GTEST_SKIP() << info.name << " is " << info.reason;
  }
  const Engine& engine() const { return find_engine(GetParam()); }
  std::string name() const { return GetParam(); }
  std::unique_ptr<Dynamics> build(const std::shared_ptr<const Robot>& robot, const Eigen::Vector3d& g = earth) const {
    return engine().build(robot, g);
  }
  Worst worst(const Dynamics& dynamics) const { return {name(), dynamics.robot().name()}; }
};

// ---- closed forms ----

TEST_P(EngineConformance, PendulumAccelerationIsTheClosedForm) {
  const Pendulum model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const State state = random_state(random, dynamics->robot());
    const double exact = model.acceleration(state.q[0], state.tau[0]);
    error.see(std::abs(acceleration(*dynamics, state)[0] - exact) / std::abs(exact), fmt::format("q = {}", state.q[0]));
  }
  EXPECT_TRUE(error.at_most(acceleration_tolerance));
}

TEST_P(EngineConformance, PendulumWithoutInertiaOfItsOwnIsTheClosedForm) {
  Pendulum model;
  model.inertia = 0.0;  // a point mass
  const auto dynamics = build(model.robot());
  const State state{{0.9}, {1.5}, {2.0}};
  const double exact = model.acceleration(0.9, 2.0);
  Worst error = worst(*dynamics);
  error.see(std::abs(acceleration(*dynamics, state)[0] - exact) / std::abs(exact), "q = 0.9");
  EXPECT_TRUE(error.at_most(name() == "ode" ? ode_point_mass_tolerance : acceleration_tolerance));
}

template <class Model>
void see_planar_errors(const Model& model, Dynamics& dynamics, Worst& error) {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const State s = random_state(random, dynamics.robot());
    const Vector2d exact = model.acceleration({s.q[0], s.q[1]}, {s.v[0], s.v[1]}, {s.tau[0], s.tau[1]});
    error.see(difference(acceleration(dynamics, s), {exact[0], exact[1]}) / exact.norm(),
              fmt::format("state {}: q = {}, {}", k, s.q[0], s.q[1]));
  }
}

TEST_P(EngineConformance, DoublePendulumAccelerationIsTheClosedForm) {
  const DoublePendulum model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  see_planar_errors(model, *dynamics, error);
  EXPECT_TRUE(error.at_most(acceleration_tolerance));
}

TEST_P(EngineConformance, CartpoleAccelerationIsTheClosedForm) {
  const Cartpole model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  see_planar_errors(model, *dynamics, error);
  EXPECT_TRUE(error.at_most(acceleration_tolerance));
}

// After a quarter of the true period the pendulum is at the bottom; what it lacks there, over its speed, is the error.
double period_error(Dynamics& dynamics, double amplitude, double period) {
  Numbers q{amplitude}, v{0.0};
  rk4_run(dynamics, q, v, {0.0}, period / 4.0, 2000);
  return std::abs(q[0] / v[0]) / period;
}

TEST_P(EngineConformance, PendulumPeriodIsTheEllipticIntegral) {
  const Pendulum model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  for (double amplitude : {0.1, 1.0, 2.0, 3.0}) {
    error.see(period_error(*dynamics, amplitude, model.period(amplitude)), fmt::format("amplitude {}", amplitude));
  }
  // The test's own integration: (2000 steps a quarter)^-4 = 6e-14, a hundredfold at amplitude 3.
  EXPECT_TRUE(error.at_most(1e-10));
}

TEST_P(EngineConformance, SmallSwingsHaveTheSmallAnglePeriod) {
  const Pendulum model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  error.see(period_error(*dynamics, 1e-4, model.small_angle_period()), "amplitude 1e-4");
  EXPECT_TRUE(error.at_most(1e-9));  // the series' next term: amplitude^2 / 16 = 6e-10
}

// ---- conservation ----

TEST_P(EngineConformance, EnergyDriftFallsAtFourthOrder) {
  const DoublePendulum model;
  const auto dynamics = build(model.robot());
  const auto drift = [&](int steps) {
    Numbers q{2.0, 1.0}, v{0.0, 1.0};
    const double start = dynamics->energy(q, v).total();
    rk4_run(*dynamics, q, v, {0.0, 0.0}, 2.0, steps);
    return std::abs(dynamics->energy(q, v).total() - start);
  };
  const double coarse = drift(400), fine = drift(800);
  // Kutta's method loses energy at h^4 or, where terms cancel, h^5; 0.8 leaves room for the next order.
  EXPECT_GT(coarse / fine, 0.8 * 16) << name() << ": drift " << coarse << " J, then " << fine << " J";
  EXPECT_LT(fine, 1e-5) << name() << ", of about 30 J in motion";
}

TEST_P(EngineConformance, EnergyIsTheClosedForm) {
  const DoublePendulum model;
  const auto dynamics = build(model.robot());
  Worst error = worst(*dynamics);
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(random, dynamics->robot());
    const double exact = model.energy({s.q[0], s.q[1]}, {s.v[0], s.v[1]});
    error.see(std::abs(dynamics->energy(s.q, s.v).total() - exact), fmt::format("state {}", k));
  }
  EXPECT_TRUE(error.at_most(1e-12 * 30.0));  // rounding of about 30 J
}

// A chain on three free slides is a body adrift: a slide lets every force along itself through, so the momentum of all
// it carries along its axis stays.
TEST_P(EngineConformance, LinearMomentumOfADriftingRobotStays) {
  Random random(4);
  std::vector<BodySpec> bodies = random_bodies(random, 7);
  for (int i = 0; i < 3; ++i) {
    BodySpec& slide = bodies[i];
    slide.parent = i - 1;
    slide.type = JointType::prismatic;
    slide.axis = Eigen::Vector3d::Unit(i);
    slide.origin = Eigen::Isometry3d::Identity();
  }
  for (int i = 3; i < 7; ++i) bodies[i].parent = std::max(2, i - 2);
  const auto dynamics = build(make_robot("drifting tree of 7", bodies), Eigen::Vector3d::Zero());
  Numbers q = random.numbers(7, 1.0), v = random.numbers(7, 2.0);
  const Numbers tau = {0, 0, 0, 1.0, -0.7, 0.4, 0.2};  // inner efforts change nothing
  const Momentum before = momentum(*dynamics, q, v);
  rk4_run(*dynamics, q, v, tau, 0.5, 1000);
  const Momentum after = momentum(*dynamics, q, v);
  Worst error = worst(*dynamics);
  for (int axis = 0; axis < 3; ++axis) {
    double change = 0.0;
    for (std::size_t i = axis; i < 7; ++i) change += (after.linear[i] - before.linear[i])[axis];
    error.see(std::abs(change), fmt::format("axis {}", axis));
  }
  EXPECT_TRUE(error.at_most(1e-7));  // kg m/s of some tens: differences of poses, and RK4
}

TEST_P(EngineConformance, AngularMomentumAboutAFreeVerticalAxisStays) {
  Random random(5);
  std::vector<BodySpec> bodies = random_bodies(random, 6);
  bodies[0].type = JointType::revolute;
  bodies[0].axis = Eigen::Vector3d::UnitZ();
  bodies[0].origin = Eigen::Isometry3d::Identity();
  for (int i = 1; i < 6; ++i) bodies[i].parent = std::max(0, i - 2);
  const auto dynamics = build(make_robot("tree of 6 on a vertical axis", bodies));  // gravity has no moment about it
  Numbers q = random.numbers(6, 1.0), v = random.numbers(6, 2.0);
  const double before = momentum(*dynamics, q, v).angular.z();
  rk4_run(*dynamics, q, v, {0.0, 1.0, -0.7, 0.4, 0.2, 0.1}, 0.5, 1000);
  Worst error = worst(*dynamics);
  error.see(std::abs(momentum(*dynamics, q, v).angular.z() - before), "0.5 s");
  EXPECT_TRUE(error.at_most(1e-7));  // kg m^2/s of some units, as above
}

// ---- native integrators ----

TEST_P(EngineConformance, NativeIntegratorsConvergeAtTheirOrder) {
  const auto robot = random_tree(6, 3);
  const auto dynamics = build(robot), exact = build(robot);
  const Numbers start_q{0.3, -0.5, 0.8}, start_v{0.4, 1.0, -0.6}, tau{0.5, -0.3, 0.2};
  Numbers true_q = start_q, true_v = start_v;
  rk4_run(*exact, true_q, true_v, tau, 0.4, 4000);
  for (const std::string& integrator : engine().info().native_integrators) {
    const auto error = [&](int steps) {
      Numbers q = start_q, v = start_v;
      for (int k = 0; k < steps; ++k) dynamics->native_step(integrator, q, v, tau, 0.4 / steps);
      return difference(q, true_q) + difference(v, true_v);
    };
    ASSERT_TRUE(native_orders.contains(integrator)) << name() << ": state the order of " << integrator;
    const int order = native_orders.at(integrator);
    const double coarse = error(40), fine = error(80);
    // At least the order less what the next one blurs. The motion itself, of size 6, must at least be about right:
    // first-order methods reach 0.13, quickstep's twenty sweeps 0.64.
    EXPECT_LT(fine, order == 0 ? 1.0 : 0.2) << name() << ", " << integrator;
    if (order > 0) {
      EXPECT_GT(std::log2(coarse / fine), order - 0.3)
          << name() << ", " << integrator << ": errors " << coarse << ", then " << fine;
    }
  }
}

// ---- the rest of the interface against forward dynamics ----

TEST_P(EngineConformance, ForwardInverseRoundTrip) {
  for (int n : {1, 6, 14}) {
    const auto dynamics = build(random_tree(70 + static_cast<std::uint64_t>(n), n), slanted);
    Worst error = worst(*dynamics);
    Random random(7);
    for (int k = 0; k < 50; ++k) {
      const State state = random_state(random, dynamics->robot());
      Numbers back(state.q.size());
      dynamics->inverse_dynamics(state.q, state.v, acceleration(*dynamics, state), back);
      error.see(difference(back, state.tau) / norm(state.tau), fmt::format("state {}", k));
    }
    EXPECT_TRUE(error.at_most(acceleration_tolerance));
  }
}

TEST_P(EngineConformance, MassMatrixIsSymmetricPositiveDefiniteAndHoldsTheKineticEnergy) {
  for (int n : {1, 6, 14}) {
    const auto dynamics = build(random_tree(80 + static_cast<std::uint64_t>(n), n));
    Worst asymmetry = worst(*dynamics), energy = worst(*dynamics);
    Random random(8);
    Eigen::MatrixXd mass;
    for (int k = 0; k < 50; ++k) {
      const State state = random_state(random, dynamics->robot());
      const std::string where = fmt::format("state {}", k);
      dynamics->mass_matrix(state.q, mass);
      asymmetry.see((mass - mass.transpose()).norm() / mass.norm(), where);
      EXPECT_EQ(mass.llt().info(), Eigen::Success) << name() << ": not positive definite at " << where;
      const Eigen::Map<const Eigen::VectorXd> v(state.v.data(), n);
      const double kinetic = dynamics->energy(state.q, state.v).kinetic;
      energy.see(std::abs(0.5 * v.dot(mass * v) - kinetic) / kinetic, where);
    }
    EXPECT_TRUE(asymmetry.at_most(1e-14));  // rounding
    EXPECT_TRUE(energy.at_most(acceleration_tolerance));
  }
}

// ---- robots at the edge ----

// How deep robots may nest differs (MuJoCo reads a description nested by body); an engine that cannot says so.
TEST_P(EngineConformance, LongChainsAreHeldOrRefused) {
  for (int n : {60, 400}) {
    Random random(19);
    std::vector<BodySpec> bodies = random_bodies(random, n);
    for (int i = 0; i < n; ++i) bodies[i].parent = i - 1;
    const auto robot = make_robot(fmt::format("chain of {}", n), bodies);
    const auto reference = featherstone_engine().build(robot, earth);
    std::unique_ptr<Dynamics> dynamics;
    try {
      dynamics = build(robot);
    } catch (const WorkError& error) {
      EXPECT_GT(n, 60) << error.what();
      continue;
    }
    State state = random_state(random, *robot);
    for (double& rate : state.v) rate *= 0.01;
    const Numbers expected = acceleration(*reference, state);
    Worst error = worst(*dynamics);
    error.see(difference(acceleration(*dynamics, state), expected) / norm(expected), "one state");
    EXPECT_TRUE(error.at_most(1e-7));  // the condition of the mass matrix grows with the square of the length
  }
}

// Moments of a thin plate printed with four digits: the largest exceeds the sum of the others by 3e-4 of itself.
TEST_P(EngineConformance, InertiasRoundedInATableAreHeld) {
  Random random(20);
  std::vector<BodySpec> bodies = random_bodies(random, 3);
  for (BodySpec& body : bodies) {
    const Eigen::Matrix3d axes = random.rotation();
    body.inertial.inertia = axes * Eigen::Vector3d(0.02, 0.03, 0.050015).asDiagonal() * axes.transpose();
    body.inertial.inertia = (0.5 * (body.inertial.inertia + body.inertial.inertia.transpose())).eval();
    body.inertial.com *= 1e-3;  // so that the mass does not make up for it about the frame either
  }
  const auto robot = make_robot("rounded plates", bodies);
  const auto dynamics = build(robot), reference = featherstone_engine().build(robot, earth);
  Worst error = worst(*dynamics);
  for (int k = 0; k < 20; ++k) {
    const State state = random_state(random, *robot);
    const Numbers expected = acceleration(*reference, state);
    error.see(difference(acceleration(*dynamics, state), expected) / norm(expected), fmt::format("state {}", k));
  }
  // Simbody holds no such body and says in its capabilities what it does instead; the table was no better.
  EXPECT_TRUE(error.at_most(name() == "simbody" ? 1e-3 : acceleration_tolerance));
}

// ---- changes in place ----

TEST_P(EngineConformance, GravityInPlaceEqualsAFreshBuild) {
  const auto robot = random_tree(9, 8);
  const auto changed = build(robot, earth), fresh = build(robot, slanted);
  changed->set_gravity(slanted);
  Random random(9);
  for (int k = 0; k < 20; ++k) {
    const State state = random_state(random, *robot);
    EXPECT_EQ(acceleration(*changed, state), acceleration(*fresh, state)) << name() << ", state " << k;
    EXPECT_EQ(changed->energy(state.q, state.v).potential, fresh->energy(state.q, state.v).potential) << name();
  }
}

TEST_P(EngineConformance, PayloadInPlaceEqualsAFreshBuild) {
  Random random(10);
  std::vector<BodySpec> bodies = random_bodies(random, 8);
  const auto changed = build(make_robot("tree of 8", bodies));
  // Twice, so that something must also be forgotten; a heavier body and one whose centre of mass and axes move.
  changed->set_inertial(3, random_inertial(random));
  for (int body : {3, 7, 0}) {
    BodySpec& spec = bodies[body];
    spec.inertial = welded(spec.inertial, random_inertial(random));
    changed->set_inertial(body, spec.inertial);
  }
  const auto fresh = build(make_robot("tree of 8 with payloads", bodies));
  for (int k = 0; k < 20; ++k) {
    const State state = random_state(random, fresh->robot());
    EXPECT_EQ(acceleration(*changed, state), acceleration(*fresh, state)) << name() << ", state " << k;
    EXPECT_EQ(changed->energy(state.q, state.v).total(), fresh->energy(state.q, state.v).total()) << name();
  }
}

// ---- independence ----

TEST_P(EngineConformance, ClonesAreIndependent) {
  const auto robot = random_tree(11, 6);
  const auto original = build(robot);
  Random random(11);
  const Inertial heavy = random_inertial(random).scaled(3.0);
  original->set_inertial(2, heavy);
  original->set_gravity(slanted);
  const State state = random_state(random, *robot);
  const Numbers before = acceleration(*original, state);
  const auto copy = original->clone();
  EXPECT_EQ(acceleration(*copy, state), before) << name() << ": a clone keeps the parameters set";
  copy->set_inertial(2, heavy.scaled(0.5));
  copy->set_gravity(earth);
  EXPECT_NE(acceleration(*copy, state), before) << name();
  EXPECT_EQ(acceleration(*original, state), before) << name() << ": changing the clone changed the original";
}

TEST_P(EngineConformance, ResultsDoNotDependOnEarlierCalls) {
  const auto robot = random_tree(12, 9);
  const auto used = build(robot);
  Random random(12);
  const State state = random_state(random, *robot);
  for (int k = 0; k < 5; ++k) {
    State other = random_state(random, *robot);
    Numbers out(other.q.size());
    Eigen::MatrixXd mass;
    std::vector<Eigen::Isometry3d> poses;
    acceleration(*used, other);
    used->inverse_dynamics(other.q, other.v, other.tau, out);
    used->mass_matrix(other.q, mass);
    used->body_poses(other.q, poses);
    used->energy(other.q, other.v);
    for (const std::string& integrator : engine().info().native_integrators) {
      used->native_step(integrator, other.q, other.v, other.tau, 1e-3);
    }
    const auto fresh = build(robot);
    EXPECT_EQ(acceleration(*used, state), acceleration(*fresh, state)) << name();
    for (const std::string& integrator : engine().info().native_integrators) {
      State a = state, b = state;
      used->native_step(integrator, a.q, a.v, a.tau, 1e-3);
      build(robot)->native_step(integrator, b.q, b.v, b.tau, 1e-3);
      EXPECT_EQ(a.q, b.q) << name() << ", " << integrator;
      EXPECT_EQ(a.v, b.v) << name() << ", " << integrator;
    }
  }
}

TEST_P(EngineConformance, ThreadsBuildAndComputeAtOnce) {
  const auto robot = random_tree(13, 7);
  constexpr int threads = 4, states = 50;
  const auto run = [&](std::vector<Numbers>& out) {
    for (int round = 0; round < 3; ++round) {
      const auto dynamics = build(robot);
      const auto copy = dynamics->clone();
      Random random(13);
      out.clear();
      for (int k = 0; k < states; ++k) {
        State state = random_state(random, *robot);
        out.push_back(acceleration(k % 2 == 0 ? *dynamics : *copy, state));
        copy->native_step(engine().info().native_integrators.back(), state.q, state.v, state.tau, 1e-3);
        out.push_back(state.v);
      }
    }
  };
  std::vector<Numbers> alone;
  run(alone);
  std::vector<std::vector<Numbers>> results(threads);
  std::vector<std::thread> pool;
  pool.reserve(threads);
  for (int t = 0; t < threads; ++t) pool.emplace_back([&, t] { run(results[t]); });
  for (std::thread& thread : pool) thread.join();
  for (const std::vector<Numbers>& result : results) EXPECT_EQ(result, alone) << name();
}

// ---- bad arguments ----

TEST_P(EngineConformance, WrongArgumentsThrow) {
  const auto dynamics = build(random_tree(14, 3));
  Numbers three(3, 0.1), two(2, 0.1), out(3);
  std::vector<Eigen::Isometry3d> poses;
  Eigen::MatrixXd mass;
  const std::string native = engine().info().native_integrators.front();
  EXPECT_THROW(dynamics->forward_dynamics(two, three, three, out), std::invalid_argument);
  EXPECT_THROW(dynamics->forward_dynamics(three, three, three, two), std::invalid_argument);
  EXPECT_THROW(dynamics->inverse_dynamics(three, two, three, out), std::invalid_argument);
  EXPECT_THROW(dynamics->mass_matrix(two, mass), std::invalid_argument);
  EXPECT_THROW(dynamics->body_poses(two, poses), std::invalid_argument);
  EXPECT_THROW(dynamics->energy(three, two), std::invalid_argument);
  EXPECT_THROW(dynamics->native_step(native, three, three, two, 1e-3), std::invalid_argument);
  EXPECT_THROW(dynamics->native_step(native, three, three, out, 0.0), std::invalid_argument);
  EXPECT_THROW(dynamics->native_step("no such method", three, three, out, 1e-3), std::invalid_argument);
  EXPECT_THROW(dynamics->set_inertial(3, Inertial{1.0, {}, Eigen::Matrix3d::Identity()}), std::invalid_argument);
  EXPECT_THROW(dynamics->set_inertial(0, Inertial{}), std::invalid_argument);
}

// A search may wander off to nonsense: the engine must say so in the result and be as before afterwards.
TEST_P(EngineConformance, NotANumberComesBackAsSuchAndLeavesNoTrace) {
  const auto robot = random_tree(15, 4);
  const auto dynamics = build(robot);
  Random random(15);
  const State good = random_state(random, *robot);
  const Numbers before = acceleration(*dynamics, good);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double bad : {nan, static_cast<double>(INFINITY), 1e200}) {
    for (int which = 0; which < 3; ++which) {
      State state = good;
      (which == 0 ? state.q : which == 1 ? state.v : state.tau)[0] = bad;
      // An infinite effort may stay infinite; what matters is that the result is not taken for a number.
      Numbers a(state.q.size());
      EXPECT_NO_THROW(a = acceleration(*dynamics, state)) << name() << ", argument " << which << " = " << bad;
      if (bad == 1e200) continue;  // finite, and may overflow or not: no throw is all
      EXPECT_FALSE(std::isfinite(a[0])) << name() << ", argument " << which;
      for (const std::string& integrator : engine().info().native_integrators) {
        State step = state;
        dynamics->native_step(integrator, step.q, step.v, step.tau, 1e-3);
        EXPECT_FALSE(std::isfinite(step.q[0]) && std::isfinite(step.v[0])) << name() << ", " << integrator;
      }
      Numbers tau(state.q.size());
      std::vector<Eigen::Isometry3d> poses;
      Eigen::MatrixXd mass;
      EXPECT_NO_THROW(dynamics->mass_matrix(state.q, mass));
      EXPECT_NO_THROW(dynamics->inverse_dynamics(state.q, state.v, state.tau, tau));
      EXPECT_NO_THROW(dynamics->body_poses(state.q, poses));
      EXPECT_NO_THROW(dynamics->energy(state.q, state.v));
    }
  }
  EXPECT_EQ(acceleration(*dynamics, good), before) << name();
}

// Nor may a load that leaves a joint nothing to move end the program, whatever the accelerations are then.
TEST_P(EngineConformance, AJointWithoutInertiaDoesNoHarmAndLeavesNoTrace) {
  Random random(21);
  std::vector<BodySpec> bodies = random_bodies(random, 3);
  bodies[2].parent = 1;
  bodies[2].type = JointType::revolute;
  const auto dynamics = build(make_robot("tree of 3", bodies));
  const State state = random_state(random, dynamics->robot());
  const Numbers before = acceleration(*dynamics, state);
  dynamics->set_inertial(2, Inertial{1.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()});
  EXPECT_NO_THROW(acceleration(*dynamics, state)) << name();
  for (const std::string& integrator : engine().info().native_integrators) {
    State step = state;
    EXPECT_NO_THROW(dynamics->native_step(integrator, step.q, step.v, step.tau, 1e-3)) << name() << ", " << integrator;
  }
  dynamics->set_inertial(2, bodies[2].inertial);
  EXPECT_EQ(acceleration(*dynamics, state), before) << name();
}

// ---- random trees against Featherstone ----

TEST_P(EngineConformance, RandomTreesAgreeWithFeatherstone) {
  constexpr int states = 1000;
  for (int n : {1, 2, 3, 6, 12, 20, 30}) {
    const auto robot = random_tree(100 + static_cast<std::uint64_t>(n), n);
    const auto dynamics = build(robot, slanted);
    const auto reference = featherstone_engine().build(robot, slanted);
    Worst error = worst(*dynamics);
    Random random(16);
    for (int k = 0; k < states; ++k) {
      const State state = random_state(random, *robot);
      const Numbers expected = acceleration(*reference, state);
      error.see(difference(acceleration(*dynamics, state), expected) / norm(expected), fmt::format("state {}", k));
    }
    EXPECT_TRUE(error.at_most(acceleration_tolerance));
  }
}

TEST_P(EngineConformance, BodyPosesAgreeWithFeatherstone) {
  for (int n : {1, 6, 30}) {
    const auto robot = random_tree(200 + static_cast<std::uint64_t>(n), n);
    const auto dynamics = build(robot), reference = featherstone_engine().build(robot, earth);
    Worst error = worst(*dynamics);
    Random random(17);
    std::vector<Eigen::Isometry3d> poses, expected;
    for (int k = 0; k < 100; ++k) {
      const State state = random_state(random, *robot);
      dynamics->body_poses(state.q, poses);
      reference->body_poses(state.q, expected);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        error.see((poses[i].matrix() - expected[i].matrix()).cwiseAbs().maxCoeff(),
                  fmt::format("state {}, body {}", k, i));
      }
    }
    EXPECT_TRUE(error.at_most(pose_tolerance));
  }
}

TEST_P(EngineConformance, MassMatrixInverseDynamicsAndEnergyAgreeWithFeatherstone) {
  for (int n : {3, 12, 30}) {
    const auto robot = random_tree(300 + static_cast<std::uint64_t>(n), n);
    const auto dynamics = build(robot, slanted), reference = featherstone_engine().build(robot, slanted);
    Worst matrix = worst(*dynamics), effort = worst(*dynamics), energy = worst(*dynamics);
    Random random(18);
    Eigen::MatrixXd mass, expected_mass;
    for (int k = 0; k < 20; ++k) {
      const State state = random_state(random, *robot);
      const std::string where = fmt::format("state {}", k);
      dynamics->mass_matrix(state.q, mass);
      reference->mass_matrix(state.q, expected_mass);
      matrix.see((mass - expected_mass).norm() / expected_mass.norm(), "mass matrix, " + where);
      Numbers tau(state.q.size()), expected(state.q.size());
      dynamics->inverse_dynamics(state.q, state.v, state.tau, tau);
      reference->inverse_dynamics(state.q, state.v, state.tau, expected);
      effort.see(difference(tau, expected) / norm(expected), "effort, " + where);
      const Energy found = dynamics->energy(state.q, state.v), wanted = reference->energy(state.q, state.v);
      energy.see(std::abs(found.total() - wanted.total()) / wanted.kinetic, "energy, " + where);
    }
    EXPECT_TRUE(matrix.at_most(acceleration_tolerance));
    EXPECT_TRUE(effort.at_most(acceleration_tolerance));
    EXPECT_TRUE(energy.at_most(1e-10));  // a sum over 30 bodies, no solve in it
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineConformance, testing::ValuesIn(engine_names()),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace lacuna::test
