// Losses by the engines' own models in their own steps, against a mass on a slide, whose motion is known in closed
// form.
#include <gtest/gtest.h>

#include <cmath>

#include "backends/engine.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kMass = 2.0, kStep = 1e-3;

std::unique_ptr<Dynamics> slide(const Engine& engine) {
  return engine.build(Robot::from_urdf_text(
                          "<robot name='slide'><link name='rail'/><link name='cart'><inertial><mass value='2'/>"
                          "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>"
                          "<joint name='x' type='prismatic'><parent link='rail'/><child link='cart'/><limit lower='-9' "
                          "upper='9' effort='9' velocity='9'/></joint></robot>",
                          "slide"),
                      Eigen::Vector3d::Zero());
}

struct State {
  double q = 0.0, v = 0.0;
};
State run(Dynamics& dynamics, const std::string& integrator, double v, double effort, double seconds) {
  std::vector<double> q{0.0}, rate{v};
  const std::vector<double> tau{effort};
  for (int k = 0; k < std::lround(seconds / kStep); ++k) dynamics.native_step(integrator, q, rate, tau, kStep);
  return {q[0], rate[0]};
}

template <class Work>
void for_every_engine_that_has_them(const Work& work) {
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (!info.available || !info.own_losses) continue;
    for (const std::string& integrator : info.native_integrators) {
      SCOPED_TRACE(info.name + ", " + integrator);
      work(*engine, integrator);
    }
  }
}

TEST(OwnLosses, DampingSlowsAMassExponentially) {
  for_every_engine_that_has_them([](const Engine& engine, const std::string& integrator) {
    const auto dynamics = slide(engine);
    dynamics->set_own_losses(std::vector<JointLoss>{{3.0, 0.0}});
    // First-order methods err by half of rate times step, relative, a second of decay at a rate of 1.5/s.
    EXPECT_NEAR(run(*dynamics, integrator, 1.0, 0.0, 1.0).v, std::exp(-3.0 / kMass), 1.5 * 1.5 * kStep);
  });
}

TEST(OwnLosses, FrictionSlowsEvenlyAndThenHolds) {
  for_every_engine_that_has_them([](const Engine& engine, const std::string& integrator) {
    const auto dynamics = slide(engine);
    dynamics->set_own_losses(std::vector<JointLoss>{{0.0, 1.0}});
    // Engines may soften the bound (MuJoCo's constraints give way by a few per cent).
    EXPECT_NEAR(run(*dynamics, integrator, 1.0, 0.0, 1.0).v, 1.0 - 1.0 / kMass, 0.05);
    EXPECT_NEAR(run(*dynamics, integrator, 1.0, 0.0, 4.0).v, 0.0, 1e-3);
    const double frictionless = 0.5 * 0.5 / kMass;  // m, in a second
    EXPECT_LT(std::fabs(run(*dynamics, integrator, 0.0, 0.5, 1.0).q), 0.01 * frictionless) << "half the bound holds it";
    EXPECT_GT(run(*dynamics, integrator, 0.0, 3.0, 1.0).v, 0.9) << "three times the bound does not";
  });
}

TEST(OwnLosses, LeaveAccelerationsAloneAndGoAgain) {
  for_every_engine_that_has_them([](const Engine& engine, const std::string& integrator) {
    const auto dynamics = slide(engine), untouched = slide(engine);
    const std::vector<double> q{0.1}, v{0.7}, tau{0.3};
    std::vector<double> before(1), after(1);
    untouched->forward_dynamics(q, v, tau, before);
    dynamics->set_own_losses(std::vector<JointLoss>{{3.0, 1.0}});
    dynamics->forward_dynamics(q, v, tau, after);
    EXPECT_EQ(before, after);
    const State slowed = run(*dynamics, integrator, 1.0, 0.0, 0.1);
    EXPECT_EQ(run(*dynamics->clone(), integrator, 1.0, 0.0, 0.1).v, slowed.v);
    dynamics->set_inertial(0, {2.0 * kMass, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()});
    EXPECT_GT(run(*dynamics, integrator, 1.0, 0.0, 0.1).v, slowed.v) << "twice the mass loses less";
    dynamics->set_inertial(0, {kMass, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()});
    dynamics->set_own_losses({});
    EXPECT_EQ(run(*dynamics, integrator, 1.0, 0.2, 0.1).v, run(*untouched, integrator, 1.0, 0.2, 0.1).v);
  });
}

TEST(OwnLosses, AreRefusedWhereThereAreNoneOrTheyAreNoLosses) {
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (!info.available) continue;
    const auto dynamics = slide(*engine);
    const std::vector<JointLoss> negative{{-1.0, 0.0}}, two(2), one{{1.0, 0.0}};
    EXPECT_THROW(dynamics->set_own_losses(negative), std::invalid_argument) << info.name;
    EXPECT_THROW(dynamics->set_own_losses(two), std::invalid_argument) << info.name;
    if (!info.own_losses) {
      EXPECT_THROW(dynamics->set_own_losses(one), WorkError) << info.name;
    }
  }
}

}  // namespace
}  // namespace lacuna
