// What Dynamics itself does, with an engine that knows nothing but forward dynamics.
#include "backends/engine.h"

#include <gtest/gtest.h>

#include "tests/reference/cartpole.h"

namespace lacuna::test {
namespace {

/// The cartpole's closed form as an engine.
class ClosedFormDynamics final : public Dynamics {
 public:
  explicit ClosedFormDynamics(const std::shared_ptr<const Robot>& robot) : Dynamics(robot) {}
  std::unique_ptr<Dynamics> clone() const override { return std::make_unique<ClosedFormDynamics>(*this); }
  ClosedFormDynamics(const ClosedFormDynamics&) = default;

  int inertials_set = 0;

 protected:
  void do_set_inertial(int, const Inertial&) override { ++inertials_set; }
  void do_set_gravity(const Eigen::Vector3d&) override {}
  void do_forward_dynamics(const double* q, const double* v, const double* tau, double* a) override {
    const Eigen::Vector2d found = model_.acceleration({q[0], q[1]}, {v[0], v[1]}, {tau[0], tau[1]});
    a[0] = found[0];
    a[1] = found[1];
  }
  void do_body_poses(const double*, std::vector<Eigen::Isometry3d>&) override {}
  Energy do_energy(const double*, const double*) override { return {}; }
  void do_native_step(const std::string&, double*, double*, const double*, double) override {}

 private:
  Cartpole model_;
};

TEST(DynamicsDefaults, MassMatrixComesFromForwardDynamics) {
  const Cartpole model;
  ClosedFormDynamics dynamics(model.robot());
  Eigen::MatrixXd mass;
  dynamics.mass_matrix(std::vector<double>{0.3, 0.7}, mass);
  const double coupling = -model.pole * model.length * std::cos(0.7);
  // Rounding of the falls that are subtracted, some 10 m/s^2.
  EXPECT_NEAR(mass(0, 0), model.cart + model.pole, 1e-12);
  EXPECT_NEAR(mass(0, 1), coupling, 1e-12);
  EXPECT_EQ(mass(1, 0), mass(0, 1));
  EXPECT_NEAR(mass(1, 1), model.inertia + model.pole * model.length * model.length, 1e-12);
}

TEST(DynamicsDefaults, InverseUndoesForward) {
  ClosedFormDynamics dynamics(Cartpole{}.robot());
  const std::vector<double> q{0.1, -2.0}, v{1.0, 3.0}, tau{4.0, -0.5};
  std::vector<double> a(2), back(2);
  dynamics.forward_dynamics(q, v, tau, a);
  dynamics.inverse_dynamics(q, v, a, back);
  EXPECT_NEAR(back[0], tau[0], 1e-12);
  EXPECT_NEAR(back[1], tau[1], 1e-12);
}

TEST(DynamicsArguments, ErrorsSayWhatWasFoundAndExpected) {
  ClosedFormDynamics dynamics(Cartpole{}.robot());
  std::vector<double> two(2), three(3);
  try {
    dynamics.forward_dynamics(two, three, two, two);
    FAIL() << "three rates for two joints passed";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "Dynamics: v has 3 numbers, expected 2");
  }
}

TEST(DynamicsArguments, ImpossibleMassesNeverReachTheEngine) {
  ClosedFormDynamics dynamics(Cartpole{}.robot());
  Inertial inertial{1.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  for (double mass : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    inertial.mass = mass;
    EXPECT_THROW(dynamics.set_inertial(0, inertial), std::invalid_argument) << mass;
  }
  inertial.mass = 1.0;
  inertial.com.x() = std::nan("");
  EXPECT_THROW(dynamics.set_inertial(0, inertial), std::invalid_argument);
  inertial.com.x() = 0.0;
  EXPECT_THROW(dynamics.set_inertial(-1, inertial), std::invalid_argument);
  EXPECT_THROW(dynamics.set_inertial(2, inertial), std::invalid_argument);
  EXPECT_EQ(dynamics.inertials_set, 0);
  dynamics.set_inertial(1, inertial);
  EXPECT_EQ(dynamics.inertials_set, 1);
}

TEST(DynamicsArguments, GravityAndStepMustBeNumbers) {
  ClosedFormDynamics dynamics(Cartpole{}.robot());
  std::vector<double> two(2);
  EXPECT_THROW(dynamics.set_gravity({0, 0, std::nan("")}), std::invalid_argument);
  EXPECT_THROW(dynamics.native_step("any", two, two, two, -1e-3), std::invalid_argument);
  EXPECT_THROW(dynamics.native_step("any", two, two, two, std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna::test
