#include "render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "render/figure.h"
#include "tests/render/test_robots.h"

namespace lacuna {
namespace {

using Eigen::Vector3d;
using PoseSets = std::vector<std::vector<Eigen::Isometry3d>>;

PoseSets arm_poses(const Robot& robot) {
  return {test::link_poses(robot, {0, 0, 0}), test::link_poses(robot, {0.5, 0.8, -1.2}),
          test::link_poses(robot, {-0.7, -0.6, 2.0})};
}

TEST(Camera, AxesAreARightHandedFrame) {
  Camera camera;
  camera.azimuth = 0.7;
  camera.elevation = -0.4;
  const Eigen::Matrix3d axes = camera.axes();
  EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((axes.col(0).cross(axes.col(1)) + axes.col(2)).norm(), 1e-14) << "sight x right = down";
  EXPECT_GT(axes.col(2).z(), 0) << "up in the picture is up in the world";
}

TEST(Camera, TargetIsInTheMiddleAndRightIsRight) {
  Camera camera;
  camera.azimuth = std::numbers::pi / 2;
  camera.elevation = 0;
  camera.target = {1, 2, 3};
  const Vector3d middle = project(camera, 640, 480, camera.target);
  EXPECT_NEAR(middle.x(), 320, 1e-9);
  EXPECT_NEAR(middle.y(), 240, 1e-9);
  EXPECT_NEAR(middle.z(), camera.distance, 1e-12);
  EXPECT_GT(project(camera, 640, 480, {1.1, 2, 3}).x(), 320);
  EXPECT_LT(project(camera, 640, 480, {1, 2, 3.1}).y(), 240) << "rows count from the top";
}

TEST(FitCamera, EveryCornerOfEveryPoseIsInThePicture) {
  const auto robot = test::robot(test::kArm);
  const PoseSets poses = arm_poses(*robot);
  const Camera camera = fit_camera(*robot, poses);
  for (const auto& [width, height] : {std::pair{960, 720}, {400, 400}, {300, 900}, {1600, 500}}) {
    for (const auto& pose : poses) {
      for (const Solid& solid : robot_figure(*robot, pose)) {
        for (const Vector3d& corner : corners(solid)) {
          const Vector3d at = project(camera, width, height, corner);
          EXPECT_GT(at.z(), 0);
          EXPECT_TRUE(at.x() >= 0 && at.x() <= width && at.y() >= 0 && at.y() <= height)
              << width << " x " << height << ": " << at.transpose();
        }
      }
    }
  }
}

TEST(FitCamera, FillsAtLeastHalfOfThePicture) {
  const auto robot = test::robot(test::kArm);
  const PoseSets poses{test::link_poses(*robot, {0, 0, 0})};
  const Camera camera = fit_camera(*robot, poses);
  double left = 1e9, right = -1e9;
  for (const Solid& solid : robot_figure(*robot, poses[0])) {
    for (const Vector3d& corner : corners(solid)) {
      left = std::min(left, project(camera, 960, 720, corner).x());
      right = std::max(right, project(camera, 960, 720, corner).x());
    }
  }
  EXPECT_GT(right - left, 0.5 * 960);
}

TEST(FitCamera, LooksAcrossTheHingesAndStandsOnTheLowestPoint) {
  const auto robot = test::robot(test::kArm);
  const Camera camera = fit_camera(*robot, PoseSets{test::link_poses(*robot, {0, -0.5, 0})});
  EXPECT_GT(std::abs(camera.axes().col(0).y()), 0.6) << "the hinges lie along y";
  EXPECT_LT(camera.axes().col(0).z(), 0) << "from above";
  EXPECT_LE(camera.ground, 0);
}

TEST(FitCamera, SameArgumentsSameCamera) {
  const auto robot = test::robot(test::kArm);
  const Camera a = fit_camera(*robot, arm_poses(*robot)), b = fit_camera(*robot, arm_poses(*robot));
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.azimuth, b.azimuth);
  EXPECT_EQ(a.ground, b.ground);
}

TEST(FitCamera, NeedsPosesAndAnAspect) {
  const auto robot = test::robot(test::kArm);
  EXPECT_THROW(fit_camera(*robot, {}), std::invalid_argument);
  EXPECT_THROW(fit_camera(*robot, arm_poses(*robot), 0.0), std::invalid_argument);
  EXPECT_THROW(fit_camera(*robot, arm_poses(*robot), std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace lacuna
