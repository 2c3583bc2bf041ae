// The referees checked by themselves, before they judge any engine.
#include <gtest/gtest.h>

#include "tests/reference/cartpole.h"
#include "tests/reference/double_pendulum.h"
#include "tests/reference/pendulum.h"

namespace lacuna::test {
namespace {

using Eigen::Vector2d;

// The energy's rate along the closed-form motion, by central differences over 1e-5 s. Truncation: h^2 = 1e-10 times
// third derivatives of the energy, some hundred J/s^3; rounding: 1e-16 of 50 J over h, 1e-9 W.
constexpr double difference_step = 1e-5;
constexpr double power_tolerance = 1e-6;

/// Power put in by the efforts must be the rate of the energy: fails for a wrong sign in any term.
template <class Model>
void expect_energy_rate_is_power(const Model& model) {
  double worst = 0.0;
  int where = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector2d q(std::sin(1.0 + k), std::cos(2.3 * k)), v(2.0 * std::cos(0.7 * k), std::sin(1.9 * k));
    const Vector2d tau(std::sin(3.1 * k), 2.0 * std::cos(0.3 * k));
    const Vector2d a = model.acceleration(q, v, tau);
    const double h = difference_step;
    const double after = model.energy(q + h * v + 0.5 * h * h * a, v + h * a);
    const double before = model.energy(q - h * v + 0.5 * h * h * a, v - h * a);
    const double error = std::abs((after - before) / (2.0 * h) - tau.dot(v));
    if (error > worst) {
      worst = error;
      where = k;
    }
  }
  EXPECT_LT(worst, power_tolerance) << "W, at state " << where;
}

TEST(ClosedForms, DoublePendulumEnergyRateIsPower) { expect_energy_rate_is_power(DoublePendulum{}); }
TEST(ClosedForms, CartpoleEnergyRateIsPower) { expect_energy_rate_is_power(Cartpole{}); }

TEST(ClosedForms, CartpoleOnAHeavyCartIsAPendulum) {
  Cartpole heavy;
  heavy.cart = 1e12;
  const Pendulum alone{heavy.pole, heavy.length, heavy.inertia, heavy.gravity};
  for (double q : {-2.0, -0.4, 0.0, 1.1, 3.0}) {
    const Vector2d a = heavy.acceleration({0.0, q}, {0.3, -1.2}, {5.0, 0.7});
    EXPECT_NEAR(a[1], alone.acceleration(q, 0.7), 1e-9) << "at q = " << q;  // 1 / cart is 1e-12
  }
}

TEST(ClosedForms, DoublePendulumWithAWeightlessLowerBarIsAPendulum) {
  DoublePendulum model;
  model.mass[1] = 0.0;
  const Pendulum alone{model.mass[0], model.com[0], model.inertia[0], model.gravity};
  const Vector2d a = model.acceleration({0.8, -0.5}, {1.0, 2.0}, {0.4, 0.0});
  EXPECT_NEAR(a[0], alone.acceleration(0.8, 0.4), 1e-12);
}

TEST(ClosedForms, PeriodGrowsWithAmplitudeAsItsSeries) {
  const Pendulum model;
  const double amplitude = 0.2;
  // T/T0 = 1 + A^2/16 + 11 A^4/3072 + 173 A^6/737280 + O(A^8); the next term is below 1e-10 here.
  const double square = amplitude * amplitude;
  const double series = 1.0 + square / 16.0 + 11.0 * square * square / 3072.0 + 173.0 * std::pow(square, 3) / 737280.0;
  EXPECT_NEAR(model.period(amplitude) / model.small_angle_period(), series, 1e-10);
}

}  // namespace
}  // namespace lacuna::test
