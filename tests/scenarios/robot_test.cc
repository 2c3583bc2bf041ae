#include "scenarios/robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "scenarios/inertial.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::input_error;
using testing::HasSubstr;

Eigen::Isometry3d some_pose() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Vector3d(0.3, -0.2, 0.5);
  return pose;
}

Inertial some_piece(double mass = 2.0) {
  Inertial piece{mass, {0.1, 0.2, -0.3}, Matrix3d::Zero()};
  piece.inertia << 0.30, 0.01, -0.02, 0.01, 0.25, 0.03, -0.02, 0.03, 0.20;
  return piece;
}

/// Inertia about the frame's origin.
Matrix3d about_origin(const Inertial& piece) {
  return piece.inertia +
         piece.mass * (piece.com.squaredNorm() * Matrix3d::Identity() - piece.com * piece.com.transpose());
}

TEST(Inertial, SeenFromAnotherFrameAndBackIsTheSame) {
  const Inertial piece = some_piece();
  const Inertial back = piece.seen_from(some_pose()).seen_from(some_pose().inverse());
  EXPECT_NEAR((back.com - piece.com).norm(), 0.0, 1e-15);
  EXPECT_NEAR((back.inertia - piece.inertia).norm(), 0.0, 1e-15);
}

TEST(Inertial, WeldingAddsInertiasAboutAnyCommonPoint) {
  const Inertial a = some_piece(), b = some_piece(3.0).seen_from(some_pose());
  const Inertial sum = welded(a, b);
  EXPECT_DOUBLE_EQ(sum.mass, 5.0);
  EXPECT_NEAR((about_origin(sum) - about_origin(a) - about_origin(b)).norm(), 0.0, 1e-14);
}

TEST(Inertial, ScalingKeepsGeometry) {
  const Inertial heavy = some_piece().scaled(2.5);
  EXPECT_DOUBLE_EQ(heavy.mass, 5.0);
  EXPECT_EQ(heavy.com, some_piece().com);
  EXPECT_NEAR((heavy.inertia - 2.5 * some_piece().inertia).norm(), 0.0, 1e-15);
}

TEST(Inertial, TriangleInequalityHoldsUpToTheRoundingOfTables) {
  Inertial rod{1.0, Vector3d::Zero(), Vector3d(0.00010, 0.1000, 0.1001).asDiagonal()};
  EXPECT_NO_THROW(check_inertial(rod, "rod"));
  rod.inertia = Vector3d(0.0, 0.1000, 0.10005).asDiagonal();
  EXPECT_NO_THROW(check_inertial(rod, "rod")) << "a thin rod, rounded";
  rod.inertia = Vector3d(0.0, 0.1000, 0.1010).asDiagonal();
  EXPECT_THAT(input_error([&] { check_inertial(rod, "file:3: link rod"); }),
              testing::AllOf(HasSubstr("file:3: link rod: inertia: found principal moments"), HasSubstr("triangle")));
}

TEST(Inertial, TriangleInequalityIsThatOfPrincipalMoments) {
  // The diagonal alone would pass: it is rotated into equality.
  const Matrix3d turn = Eigen::AngleAxisd(0.8, Vector3d(1, 1, 1).normalized()).toRotationMatrix();
  const Inertial piece{1.0, Vector3d::Zero(), turn * Vector3d(0.1, 0.1, 0.5).asDiagonal() * turn.transpose()};
  EXPECT_THAT(input_error([&] { check_inertial(piece, "x"); }), HasSubstr("triangle"));
}

TEST(Inertial, NegativeMomentsAreRefused) {
  const Inertial piece{1.0, Vector3d::Zero(), Vector3d(-0.1, 0.3, 0.3).asDiagonal()};
  EXPECT_THAT(input_error([&] { check_inertial(piece, "x"); }), HasSubstr("none below 0"));
}

struct Parts {
  std::vector<Joint> joints;
  std::vector<Link> links;
};

Parts two_links() {
  Parts parts;
  parts.links = {{"base", -1, Eigen::Isometry3d::Identity(), {}, {}},
                 {"upper", 0, Eigen::Isometry3d::Identity(), some_piece(), {}},
                 {"lower", 1, Eigen::Isometry3d::Identity(), some_piece(1.0), {}}};
  Joint a, b;
  a.name = "a";
  a.link = 1;
  b.name = "b";
  b.link = 2;
  b.parent = 0;
  parts.joints = {a, b};
  return parts;
}

std::string refusal(const Parts& parts) {
  return input_error([&] { Robot("r", parts.joints, parts.links, "arm.urdf"); });
}

TEST(Robot, KeepsWhatItWasGiven) {
  const Parts parts = two_links();
  const Robot robot("r", parts.joints, parts.links, "arm.urdf");
  EXPECT_EQ(robot.dof(), 2);
  EXPECT_EQ(robot.find_joint("b"), 1);
  EXPECT_EQ(robot.find_link("lower"), 2);
  EXPECT_FALSE(robot.find_joint("c"));
  EXPECT_DOUBLE_EQ(robot.moving_mass(), 3.0);
}

TEST(Robot, RefusesImpossibleTrees) {
  Parts parts = two_links();
  parts.joints[0].parent = 0;
  EXPECT_THAT(refusal(parts), HasSubstr("arm.urdf: joint a: parent: found body 0"));
  parts = two_links();
  parts.joints[1].name = "a";
  EXPECT_THAT(refusal(parts), HasSubstr("the name \"a\" twice"));
  parts = two_links();
  parts.joints[1].axis = {0, 0, 2};
  EXPECT_THAT(refusal(parts), HasSubstr("joint b: axis: found length 2, expected a unit vector"));
  parts = two_links();
  parts.joints[1].link = 1;
  EXPECT_THAT(refusal(parts), HasSubstr("joint b: link"));
  parts = two_links();
  parts.links[1].inertial = {};
  EXPECT_THAT(refusal(parts), HasSubstr("joint a: found a moved link without mass"));
  parts = two_links();
  parts.links[2].inertial = {1.0, Vector3d::Zero(), Matrix3d::Zero()};
  EXPECT_THAT(refusal(parts), HasSubstr("joint b: found no inertia about its axis"));
  parts = two_links();
  parts.joints.clear();
  EXPECT_THAT(refusal(parts), HasSubstr("arm.urdf"));
}

TEST(Robot, BodyInertialWeldsEveryLinkThatRidesOnTheBody) {
  Parts parts = two_links();
  parts.links.push_back({"sensor", 0, some_pose(), some_piece(0.5), {}});
  const Robot robot("r", parts.joints, parts.links, "arm.urdf");
  const Inertial sum = robot.body_inertial(0);
  const Inertial expected = welded(some_piece(), some_piece(0.5).seen_from(some_pose()));
  EXPECT_DOUBLE_EQ(sum.mass, 2.5);
  EXPECT_NEAR((sum.com - expected.com).norm(), 0.0, 1e-15);
  EXPECT_NEAR((sum.inertia - expected.inertia).norm(), 0.0, 1e-14);
}

TEST(Robot, LinkMassesScaleEachLinksInertia) {
  const Parts parts = two_links();
  const Robot robot("r", parts.joints, parts.links, "arm.urdf");
  const std::vector<double> masses{0.0, 4.0, 1.0};
  EXPECT_NEAR((robot.body_inertial(0, masses).inertia - 2.0 * some_piece().inertia).norm(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(robot.body_inertial(0, masses).mass, 4.0);
  EXPECT_THROW(robot.body_inertial(0, std::vector<double>{1.0}), std::invalid_argument);
}

TEST(Robot, ToolIsTheLinkOfThatName) {
  Parts parts = two_links();
  parts.links.push_back({"tool", 0, some_pose(), {}, {}});
  const Robot robot("r", parts.joints, parts.links, "arm.urdf");
  EXPECT_EQ(robot.tool().body, 0);
  EXPECT_EQ(robot.tool().point, some_pose().translation());
}

TEST(Robot, WithoutAToolTheLastLinksTipCarriesThePayload) {
  Parts parts = two_links();
  EXPECT_EQ(Robot("r", parts.joints, parts.links, "x").tool().point, 2.0 * some_piece().com) << "no visual";
  Visual box;
  box.size = {0.4, 0.1, 0.1};
  box.pose.translation() = Vector3d(0.2, 0, 0);
  parts.links[2].visuals.push_back(box);
  const auto tool = Robot("r", parts.joints, parts.links, "x").tool();
  EXPECT_EQ(tool.body, 1);
  EXPECT_NEAR((tool.point - Vector3d(0.4, 0, 0)).norm(), 0.0, 1e-15) << "the middle of the far face";
}

TEST(Robot, LinkPosesRideOnTheBodies) {
  Parts parts = two_links();
  parts.links.push_back({"sensor", 1, some_pose(), {}, {}});
  const Robot robot("r", parts.joints, parts.links, "x");
  std::vector<Eigen::Isometry3d> bodies(2, Eigen::Isometry3d::Identity());
  bodies[1].translation() = Vector3d(1, 2, 3);
  const auto poses = robot.link_poses(bodies);
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_TRUE(poses[3].isApprox(bodies[1] * some_pose()));
}

}  // namespace
}  // namespace lacuna
