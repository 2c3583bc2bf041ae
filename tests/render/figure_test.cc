#include "render/figure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "scenarios/error.h"
#include "tests/render/test_robots.h"

namespace lacuna {
namespace {

using Eigen::Vector3d;

const Solid* find(const std::vector<Solid>& figure, Solid::Kind kind, const Vector3d& at) {
  const auto it = std::find_if(figure.begin(), figure.end(), [&](const Solid& solid) {
    return solid.kind == kind && (solid.pose.translation() - at).norm() < 1e-9;
  });
  return it == figure.end() ? nullptr : &*it;
}

TEST(RobotFigure, VisualsLieWhereTheirLinksAre) {
  const auto robot = test::robot(test::kArm);
  const auto figure = robot_figure(*robot, test::link_poses(*robot, {0, 0, 0}));
  const Solid* turret = find(figure, Solid::Kind::box, {0, 0, 0.2});
  ASSERT_NE(turret, nullptr);
  EXPECT_LT((turret->half - Vector3d(0.1, 0.075, 0.1)).norm(), 1e-12) << "half of the URDF's sides";
  const Solid* boom = find(figure, Solid::Kind::cylinder, {0.3, 0, 0.3});
  ASSERT_NE(boom, nullptr);
  EXPECT_LT((boom->half - Vector3d(0.05, 0.05, 0.3)).norm(), 1e-12) << "radius, radius, half length";
  EXPECT_LT((boom->pose.linear().col(2) - Vector3d::UnitX()).norm(), 1e-6);
}

TEST(RobotFigure, ALinkWithoutVisualsIsStillSeen) {
  const auto robot = test::robot(test::kArm);
  const auto figure = robot_figure(*robot, test::link_poses(*robot, {0, 0, 0}));
  EXPECT_NE(find(figure, Solid::Kind::capsule, {0.7, 0, 0.3}), nullptr) << "a rod from the wrist to the mass";
  EXPECT_NE(find(figure, Solid::Kind::sphere, {0.8, 0, 0.3}), nullptr) << "a ball at the mass";
}

TEST(RobotFigure, PinsLieAlongTheirAxesAndStickOutOfTheLinks) {
  const auto robot = test::robot(test::kArm);
  const auto figure = robot_figure(*robot, test::link_poses(*robot, {0, 0.3, 0}));
  const Solid* pin = find(figure, Solid::Kind::cylinder, {0, 0, 0.3});
  ASSERT_NE(pin, nullptr);
  EXPECT_NEAR(std::abs(pin->pose.linear().col(2).y()), 1.0, 1e-12);
  EXPECT_GT(pin->half.z(), 0.05) << "the boom is 0.1 m thick";
}

TEST(RobotFigure, RailsReachFromLimitToLimitWhereverTheSlideIs) {
  const auto robot = test::robot(test::kRedBox);
  for (const double q : {-0.05, 0.0, 0.04}) {
    const auto figure = robot_figure(*robot, test::link_poses(*robot, {q}));
    const Solid* rail = find(figure, Solid::Kind::cylinder, Vector3d::Zero());
    ASSERT_NE(rail, nullptr) << q;
    EXPECT_NEAR(rail->half.z(), 0.05, 1e-12);
  }
}

TEST(RobotFigure, AMeshStandsAboutTheMiddleOfItsBoxAndShowsItsJointItself) {
  const auto robot = test::with_mesh(*test::robot(test::kArm), test::box_mesh({0, 0, 0}, {0.25f, 0.5f, 0.75f}));
  const auto figure = robot_figure(*robot, test::link_poses(*robot, {0, 0, 0}));
  // The turret's visual lies 0.1 m above its link, which stands 0.1 m above the base.
  const Solid* mesh = find(figure, Solid::Kind::mesh, {0.125, 0.25, 0.575});
  ASSERT_NE(mesh, nullptr);
  EXPECT_LT((mesh->half - Vector3d(0.125, 0.25, 0.375)).norm(), 1e-12);
  EXPECT_EQ(find(figure, Solid::Kind::cylinder, {0, 0, 0.3}), nullptr) << "no pin at the lift";
  EXPECT_NE(find(figure, Solid::Kind::cylinder, {0.6, 0, 0.3}), nullptr) << "one at the wrist, whose link has no mesh";
}

TEST(RobotFigure, AMeshThatWasNotReadIsDrawnLikeALinkWithoutVisuals) {
  const auto bare = test::robot(test::kArm);
  auto links = bare->links();
  for (Link& link : links) link.visuals.clear();
  const auto without = std::make_shared<const Robot>("arm", bare->joints(), links, "test");
  for (Link& link : links) {
    link.visuals.emplace_back();
    link.visuals.back().shape = Visual::Shape::mesh;
    link.visuals.back().mesh_file = "none.stl";
  }
  const auto unread = std::make_shared<const Robot>("arm", bare->joints(), links, "test");
  const auto a = robot_figure(*without, test::link_poses(*without, {0, 0, 0}));
  const auto b = robot_figure(*unread, test::link_poses(*unread, {0, 0, 0}));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].kind, b[i].kind);
    EXPECT_EQ(a[i].half, b[i].half);
    EXPECT_EQ(a[i].pose.matrix(), b[i].pose.matrix());
  }
}

TEST(PistonFigure, ReachesFromPinToPinAsLongAsTheLawOfCosinesHasIt) {
  const auto robot = test::robot(test::kArm);
  const Piston piston{1, 0.3, 0.08, 1.1, 0.2, 0.04, 0.02};
  for (const double q : {-0.6, 0.0, 0.9}) {
    const auto figure = piston_figure(*robot, test::link_poses(*robot, {0.4, q, 0}), piston);
    ASSERT_EQ(figure.size(), 4u);
    const Vector3d from = figure[2].pose.translation(), to = figure[3].pose.translation();
    const double length = std::sqrt(0.09 + 0.0064 - 2 * 0.3 * 0.08 * std::cos(q + 1.1));
    EXPECT_NEAR((to - from).norm(), length, 1e-12) << q;
    EXPECT_NEAR(2 * figure[0].half.z(), 0.2, 1e-12) << "the barrel keeps its length";
    EXPECT_NEAR(2 * (figure[0].half.z() + figure[1].half.z()), length, 1e-12) << "the rod is the rest";
  }
  Piston nowhere = piston;
  nowhere.joint = 9;
  EXPECT_THROW(piston_figure(*robot, test::link_poses(*robot, {0, 0, 0}), nowhere), std::invalid_argument);
}

TEST(RobotFigure, RefusesAWrongCountAndPosesThatAreNotFinite) {
  const auto robot = test::robot(test::kArm);
  auto poses = test::link_poses(*robot, {0, 0, 0});
  poses[1].translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(robot_figure(*robot, poses), WorkError);
  poses.pop_back();
  EXPECT_THROW(robot_figure(*robot, poses), std::invalid_argument);
}

TEST(Pillar, StandsUnderAnUprightFirstJointAboveTheFloor) {
  const auto arm = test::robot(test::kArm);
  const auto pillar_below = pillar(*arm, -0.4);
  ASSERT_TRUE(pillar_below);
  EXPECT_NEAR(pillar_below->half.z(), 0.2, 1e-12);
  EXPECT_FALSE(pillar(*arm, 0.0));
  EXPECT_FALSE(pillar(*test::robot(test::kRedBox), -0.4)) << "a slide would run through it";
}

TEST(JointPosition, IsTheOriginOfTheMovedLink) {
  const auto robot = test::robot(test::kArm);
  const auto poses = test::link_poses(*robot, {0, 0, 0});
  EXPECT_LT((joint_position(*robot, poses, 2) - Vector3d(0.6, 0, 0.3)).norm(), 1e-12);
  EXPECT_THROW(joint_position(*robot, poses, 3), std::invalid_argument);
  EXPECT_THROW(joint_position(*robot, poses, -1), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
