// The referee against closed forms: what engines are held against must itself be right.
#include "compare/referee.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>

#include "tests/reference/cartpole.h"
#include "tests/reference/pendulum.h"

namespace lacuna::test {
namespace {

/// rad. Doubles hold a position of some radians to 4e-16; the robot's own numbers are rounded as much, and a swing of
/// five periods multiplies that by some tens.
constexpr double kClosedForm = 1e-13;
/// rad, m: what the closed-form equations leave under a double-precision integrator at 1e-13 a step.
constexpr double kIntegrated = 1e-10;

Scenario scenario_of(std::shared_ptr<const Robot> robot, double duration, std::map<std::string, double> position) {
  Scenario scenario;
  scenario.name = robot->name();
  scenario.robot = std::move(robot);
  scenario.motion = MotionSpec{};
  scenario.motion->duration = duration;
  scenario.motion->position = std::move(position);
  return scenario;
}

// From rest at A: sin(q/2) = k cd(w t, k), k = sin(A/2), cd = cn/dn (Whittaker and Watson, Modern Analysis, 22.2).
TEST(Referee, IsTheEllipticPendulum) {
  const Pendulum model;
  const double amplitude = 2.4;
  const Motion motion = motion_of(scenario_of(model.robot(), 6.0, {{"joint_0", amplitude}}), 6.0);
  const Referee referee = make_referee(motion, 1, nullptr);
  ASSERT_EQ(referee.trusted, referee.times.size());
  const long double k = std::sin(0.5L * amplitude);
  for (std::size_t i = 0; i < referee.times.size(); ++i) {
    long double cn = 0, dn = 0;
    const long double w =
        std::sqrt(model.mass * model.gravity * model.length / static_cast<long double>(model.about_axis()));
    boost::math::jacobi_elliptic(k, w * referee.times[i], &cn, &dn);
    const double exact = static_cast<double>(2.0L * std::asin(k * cn / dn));
    ASSERT_NEAR(referee.reference.q[i][0], exact, kClosedForm) << referee.times[i] << " s";
  }
}

TEST(Referee, IsTheCartpoleOfLagrange) {
  const Cartpole model;
  const Motion motion = motion_of(scenario_of(model.robot(), 2.0, {{"joint_1", 2.8}}), 2.0);
  const Referee referee = make_referee(motion, 1, nullptr);
  using State = std::array<double, 4>;  // x, q, their rates
  State state{0.0, 2.8, 0.0, 0.0};
  const auto rates = [&](const State& s, State& ds, double) {
    const Eigen::Vector2d a = model.acceleration({s[0], s[1]}, {s[2], s[3]}, {0.0, 0.0});
    ds = {s[2], s[3], a[0], a[1]};
  };
  namespace odeint = boost::numeric::odeint;
  auto stepper = odeint::make_controlled<odeint::runge_kutta_fehlberg78<State>>(1e-13, 1e-13);
  for (std::size_t i = 1; i < referee.times.size(); ++i) {
    odeint::integrate_adaptive(stepper, rates, state, referee.times[i - 1], referee.times[i], 1e-3);
    ASSERT_NEAR(referee.reference.q[i][0], state[0], kIntegrated) << referee.times[i] << " s";
    ASSERT_NEAR(referee.reference.q[i][1], state[1], kIntegrated) << referee.times[i] << " s";
  }
}

// Some hundred steps, each within the looser run's 1e-13.
TEST(Referee, TighteningChangesNoMoreThanTheLooserRunsTolerance) {
  const Motion motion = motion_of(scenario_of(Pendulum().robot(), 3.0, {{"joint_0", 2.0}}), 3.0);
  const Referee referee = make_referee(motion, 2, nullptr);
  EXPECT_LT(referee.record.error, 1e-11);
  EXPECT_EQ(referee.record.trusted_until, 3.0);
  EXPECT_GT(referee.record.seconds, 0.0);
}

TEST(Referee, IsTheSameOnAnyNumberOfThreads) {
  const Motion motion = motion_of(scenario_of(Cartpole().robot(), 0.5, {{"joint_1", 1.0}}), 0.5);
  EXPECT_EQ(make_referee(motion, 1, nullptr).reference.q, make_referee(motion, 2, nullptr).reference.q);
}

TEST(ErrorOf, FindsTheWorstJointAndInstant) {
  Referee referee;
  referee.times = {0.0, 1.0, 2.0};
  referee.trusted = 2;
  referee.reference.q = {{0, 0}, {1, 1}, {2, 2}};
  referee.top_speed = 1.0;
  Trajectory run;
  run.q = {{0, 0}, {1, 1.5}, {2, 9}};  // what the referee is not sure of does not count
  run.v = {{0, 0}, {1, 1}, {1, 1}};
  const ErrorSeries series = error_of(run, referee);
  EXPECT_EQ(series.worst, 0.5);
  EXPECT_EQ(series.worst_time, 1.0);
  EXPECT_EQ(series.worst_joint, 1);
  EXPECT_EQ(series.error, (std::vector<double>{0.0, 0.5}));
  EXPECT_DOUBLE_EQ(series.rms, 0.25);
  EXPECT_TRUE(series.stable);
  run.v[2][0] = 11.0;
  EXPECT_FALSE(error_of(run, referee).stable) << "ten times as fast as the reference";
  run.q[1][0] = std::nan("");
  EXPECT_EQ(error_of(run, referee).worst, HUGE_VAL);
}

}  // namespace
}  // namespace lacuna::test
