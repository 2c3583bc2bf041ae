// The frames that the kernels choose change nothing: special axes agree with the same robot given in another frame.
#include "backends/featherstone/mount.h"

#include <gtest/gtest.h>

#include <numbers>

#include "backends/registry.h"
#include "tests/conformance/random_robot.h"

namespace lacuna::test {
namespace {

using Eigen::Vector3d;

const double kAngles[] = {0.0, 1e-16, 1e-12, 1e-7, 1e-3, 0.09, 0.11, 0.7, std::numbers::pi / 2, 2.0, std::numbers::pi};
const Vector3d kPlaces[] = {Vector3d::Zero(), {0, 0, 0.3}, {0.4, 0, 0}, {0.2, -0.1, 0.5}};

/// Four bodies, one of them a second branch, neighbouring axes at `angle`, joints `place` apart.
std::vector<BodySpec> special(double angle, const Vector3d& place, bool slides) {
  Random random(7);
  std::vector<BodySpec> bodies(4);
  for (int i = 0; i < 4; ++i) {
    BodySpec& body = bodies[i];
    body.parent = i == 3 ? 1 : i - 1;
    body.type = slides && i == 2 ? JointType::prismatic : JointType::revolute;
    body.axis = Vector3d(0.0, std::sin(angle * (i % 2)), std::cos(angle * (i % 2)));
    body.origin.translation() = place;
    body.inertial = random_inertial(random);
  }
  return bodies;
}

TEST(Mount, RobotsOfSpecialAxesMoveAsTheirMassMatrixSays) {
  constexpr double kRelative = 1e-10;  // rounding times the condition of the mass matrix
  Random random(8);
  for (const double angle : kAngles) {
    for (const Vector3d& place : kPlaces) {
      for (const bool slides : {false, true}) {
        const auto robot = make_robot("special", special(angle, place, slides));
        const auto dynamics = featherstone_engine().build(robot, {1.3, -2.1, -9.0});
        const State state = random_state(random, *robot);
        std::vector<double> a(4), drift(4), rest(4, 0.0), back(4);
        Eigen::MatrixXd mass;
        dynamics->forward_dynamics(state.q, state.v, state.tau, a);
        dynamics->inverse_dynamics(state.q, state.v, a, back);
        dynamics->inverse_dynamics(state.q, state.v, rest, drift);
        dynamics->mass_matrix(state.q, mass);
        const Eigen::Map<const Eigen::VectorXd> tau(state.tau.data(), 4), h(drift.data(), 4), found(back.data(), 4);
        const Eigen::VectorXd by_matrix = mass * Eigen::Map<const Eigen::VectorXd>(a.data(), 4) + h;
        const double size = tau.norm() + h.norm();
        EXPECT_LT((found - tau).norm(), kRelative * size) << angle << " " << place.transpose() << " " << slides;
        EXPECT_LT((by_matrix - tau).norm(), kRelative * size) << angle << " " << place.transpose() << " " << slides;
      }
    }
  }
}

TEST(Mount, EnginesAgreeOnSpecialAxes) {
  constexpr double kRelative = 1e-9;  // as in the conformance suite
  if (!find_engine("mujoco").info().available) GTEST_SKIP() << "mujoco is not built";
  Random random(9);
  for (const double angle : kAngles) {
    for (const Vector3d& place : kPlaces) {
      const auto robot = make_robot("special", special(angle, place, true));
      const State state = random_state(random, *robot);
      std::vector<double> a(4), b(4);
      const auto solve = [&](const char* engine, std::vector<double>& out) {
        find_engine(engine).build(robot, {1.3, -2.1, -9.0})->forward_dynamics(state.q, state.v, state.tau, out);
      };
      solve("featherstone", a);
      solve("mujoco", b);
      const Eigen::Map<const Eigen::VectorXd> ours(a.data(), 4), other(b.data(), 4);
      EXPECT_LT((ours - other).norm(), kRelative * other.norm()) << angle << " " << place.transpose();
    }
  }
}

TEST(Mount, OfTheArmNeedsNoGeneralTurnAndAtMostTwoShifts) {
  const auto robot = Robot::from_urdf(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek/seed_table1.urdf");
  int shifts = 0;
  for (const Mount& mount : mounts_of(*robot)) {
    EXPECT_FALSE(mount.swings);
    EXPECT_NE(mount.tilt, Tilt::any);
    shifts += static_cast<int>((mount.shift.array() != 0.0).count());
  }
  EXPECT_EQ(shifts, 4);  // of fifteen
}

}  // namespace
}  // namespace lacuna::test
