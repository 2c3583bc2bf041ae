#include "render/snapshot.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "backends/engine.h"
#include "scenarios/error.h"
#include "tests/render/test_robots.h"

namespace lacuna {
namespace {

// Engines place links within 1e-9 m of each other. That may round a coordinate to the neighbouring float, which moves
// an edge across one of the 16 samples behind a pixel or a colour by one step. So two engines' pictures may differ by
// at most one sample (255 / 16 = 16 levels of a channel) ...
constexpr int kEngineChannelTolerance = 16;
// ... and in more than one level only at a few edge pixels: 1 in 10,000.
constexpr int kEngineRoundingLevel = 1;
constexpr double kEngineEdgeShare = 1e-4;

class Snapshot : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string reason;
    if (!render_available(&reason)) GTEST_SKIP() << reason;
  }
};

SnapshotOptions small() {
  SnapshotOptions options;
  options.width = 320;
  options.height = 240;
  return options;
}

Image arm_picture(const std::vector<double>& q, const SnapshotOptions& options) {
  const auto robot = test::robot(test::kArm);
  const std::vector<std::vector<Eigen::Isometry3d>> fitted{test::link_poses(*robot, {0, 0.3, 0.4})};
  return render_snapshot(*robot, test::link_poses(*robot, q), fit_camera(*robot, fitted), options);
}

TEST(SnapshotReason, IsGivenExactlyWhereNothingCanBeDrawn) {
  std::string reason;
  EXPECT_EQ(render_available(&reason), reason.empty());
  EXPECT_EQ(render_available(), reason.empty());
  if (reason.empty()) return;
  const auto robot = test::robot(test::kRedBox);
  EXPECT_THROW(render_snapshot(*robot, test::link_poses(*robot, {0}), Camera{}, {}), WorkError);
}

TEST_F(Snapshot, RedBoxBeforeTheCameraIsRedInTheMiddleAndNotAtTheBorder) {
  const auto robot = test::robot(test::kRedBox);
  Camera camera;
  camera.azimuth = std::numbers::pi / 2;
  camera.distance = 1.0;
  camera.radius = 0.2;
  camera.ground = -0.1;
  const Image image = render_snapshot(*robot, test::link_poses(*robot, {0}), camera, small());
  const std::uint8_t* middle = image.pixel(image.width / 2, image.height / 2);
  EXPECT_GT(middle[0], 100);
  EXPECT_LT(middle[1], middle[0] / 4);
  EXPECT_LT(middle[2], middle[0] / 4);
  for (const auto& [x, y] : {std::pair{0, 0}, {image.width - 1, 0}, {0, image.height - 1}}) {
    const std::uint8_t* border = image.pixel(x, y);
    EXPECT_GT(border[1], 150) << x << ", " << y << ": floor and background are light";
  }
}

/// A mesh is painted by other code than a box: the same box either way must give nearly the same picture.
TEST_F(Snapshot, ABoxOfTrianglesLooksLikeTheBoxItself) {
  const auto robot = test::robot(test::kRedBox);
  const auto meshed = test::with_mesh(*robot, test::box_mesh({-0.1f, -0.1f, -0.1f}, {0.2f, 0.2f, 0.2f}));
  Camera camera;
  camera.distance = 1.0;
  camera.radius = 0.2;
  camera.ground = -0.1;
  const Image triangles = render_snapshot(*meshed, test::link_poses(*meshed, {0}), camera, small());
  EXPECT_EQ(triangles.rgb, render_snapshot(*meshed, test::link_poses(*meshed, {0}), camera, small()).rgb);
  const auto red = [](const Image& image) {
    std::vector<bool> out;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3)
      out.push_back(image.rgb[i] > 60 && image.rgb[i + 1] < image.rgb[i] / 4);
    return out;
  };
  const Image solid = render_snapshot(*robot, test::link_poses(*robot, {0}), camera, small());
  const std::vector<bool> a = red(triangles), b = red(solid);
  std::size_t both = 0, one = 0;
  for (std::size_t i = 0; i < a.size(); ++i) both += a[i] && b[i], one += a[i] != b[i];
  // The plain box has a rail and stops, which stick out of it: dark pixels before and behind it.
  EXPECT_GT(both, 5000u);
  EXPECT_LT(one, both / 10);
}

TEST_F(Snapshot, PictureLiesWhereTheCameraProjects) {
  const auto robot = test::robot(test::kRedBox);
  Camera camera;
  camera.azimuth = std::numbers::pi / 2;
  camera.elevation = 0;
  camera.distance = 2.0;
  camera.radius = 0.2;
  camera.ground = -0.5;
  camera.target = {-0.25, 0, -0.12};  // the box lies upper right, so the front face's far edges are its outline
  const Image image = render_snapshot(*robot, test::link_poses(*robot, {0}), camera, small());
  const auto red = [&image](double x, double y) {
    const std::uint8_t* at = image.pixel(static_cast<int>(x), static_cast<int>(y));
    return at[0] > 60 && at[1] < at[0] / 4;
  };
  // 1.5 pixels inside and outside of where its right and its upper edge are computed to be.
  const Eigen::Vector3d edge = project(camera, image.width, image.height, {0.1, -0.1, 0});
  EXPECT_TRUE(red(edge.x() - 1.5, edge.y()));
  EXPECT_FALSE(red(edge.x() + 1.5, edge.y()));
  const Eigen::Vector3d top = project(camera, image.width, image.height, {0, -0.1, 0.1});
  EXPECT_TRUE(red(top.x(), top.y() + 1.5));
  EXPECT_FALSE(red(top.x(), top.y() - 1.5));
}

TEST_F(Snapshot, SameArgumentsSameBytesFromEveryThread) {
  SnapshotOptions options = small();
  options.caption = "featherstone";
  options.markers.push_back({1, "", {214, 20, 90}});
  const Image first = arm_picture({0.1, 0.3, 0.4}, options);
  Image second, third;
  std::thread a([&] { second = arm_picture({0.1, 0.3, 0.4}, options); });
  std::thread b([&] { third = arm_picture({0.1, 0.3, 0.4}, options); });
  a.join();
  b.join();
  EXPECT_EQ(first.rgb, second.rgb);
  EXPECT_EQ(first.rgb, third.rgb);
}

TEST_F(Snapshot, EveryMovedJointChangesThePicture) {
  const Image still = arm_picture({0, 0.3, 0.4}, small());
  for (std::size_t joint = 0; joint < 3; ++joint) {
    std::vector<double> q{0, 0.3, 0.4};
    q[joint] += 0.05;
    const ImageDifference difference = compare_images(still, arm_picture(q, small()), kEngineChannelTolerance);
    EXPECT_GT(difference.share_of_pixels_over_tolerance, kEngineEdgeShare)
        << "joint " << joint << ": the engines' comparison would not see 3 degrees";
  }
}

TEST_F(Snapshot, MarkerIsSeenAroundItsJointOnly) {
  SnapshotOptions options = small();
  const Image plain = arm_picture({0, 0.3, 0.4}, options);
  options.markers.push_back({1, "joint", {214, 20, 90}});
  const Image marked = arm_picture({0, 0.3, 0.4}, options);
  int ring = 0;
  for (int y = 0; y < marked.height; ++y) {
    for (int x = 0; x < marked.width; ++x) {
      const std::uint8_t* at = marked.pixel(x, y);
      ring += std::abs(at[0] - 214) < 12 && std::abs(at[1] - 20) < 12 && std::abs(at[2] - 90) < 12;
    }
  }
  EXPECT_GT(ring, 100);
  EXPECT_LT(compare_images(plain, marked, 0).share_of_pixels_over_tolerance, 0.1);
}

TEST_F(Snapshot, CaptionIsDrawnAndAnyTextIsBorne) {
  SnapshotOptions options = small();
  const Image plain = arm_picture({0, 0.3, 0.4}, options);
  options.caption = "simbody";
  const Image named = arm_picture({0, 0.3, 0.4}, options);
  options.caption = "mujoco";
  EXPECT_GT(compare_images(plain, named, 60).share_of_pixels_over_tolerance, 1e-3);
  EXPECT_GT(compare_images(arm_picture({0, 0.3, 0.4}, options), named, 60).share_of_pixels_over_tolerance, 1e-3);
  for (const std::string& text :
       {std::string(100'000, 'W'), std::string("\xff\x01\n\t\xc3\xa9"), std::string(3, '\0')}) {
    options.caption = options.subcaption = text;
    options.markers = {{0, text, {0, 0, 0}}};
    EXPECT_NO_THROW(arm_picture({0, 0.3, 0.4}, options));
  }
}

TEST_F(Snapshot, TilesOfALargePictureJoinWithoutSeams) {
  SnapshotOptions options = small();
  const Image whole = arm_picture({0, 0.3, 0.4}, options);  // one tile
  options.width *= 4;
  options.height *= 4;
  const Image large = arm_picture({0, 0.3, 0.4}, options);  // 1,280 pixels wide: more than one
  Image reduced = Image::filled(whole.width, whole.height, 0, 0, 0);
  for (int y = 0; y < whole.height; ++y) {
    for (int x = 0; x < 3 * whole.width; ++x) {
      int sum = 8;
      for (int i = 0; i < 16; ++i) sum += large.pixel(4 * (x / 3) + i % 4, 4 * y + i / 4)[x % 3];
      reduced.pixel(0, y)[x] = static_cast<std::uint8_t>(sum / 16);
    }
  }
  EXPECT_LT(compare_images(whole, reduced, 0).mean_channel, 1.0);
}

TEST_F(Snapshot, HostileSizesAreRefused) {
  for (const auto& [width, height] : {std::pair{0, 240},
                                      {320, 0},
                                      {-5, 240},
                                      {8193, 240},
                                      {320, 8193},
                                      {std::numeric_limits<int>::max(), std::numeric_limits<int>::max()}}) {
    SnapshotOptions options;
    options.width = width;
    options.height = height;
    EXPECT_THROW(arm_picture({0, 0, 0}, options), InputError) << width << " x " << height;
  }
}

TEST_F(Snapshot, SmallestAndLongestPicturesAreDrawn) {
  for (const auto& [width, height] : {std::pair{1, 1}, {kMaxImageSide, 8}, {8, kMaxImageSide}}) {
    SnapshotOptions options;
    options.width = width;
    options.height = height;
    options.caption = "x";
    options.markers = {{1, "", {0, 0, 0}}};
    const Image image = arm_picture({0, 0, 0}, options);
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.height, height);
  }
}

TEST_F(Snapshot, WrongPosesMarkersAndCamerasAreRefused) {
  const auto robot = test::robot(test::kArm);
  auto poses = test::link_poses(*robot, {0, 0, 0});
  const Camera camera = fit_camera(*robot, std::span(&poses, 1));
  SnapshotOptions options = small();
  options.markers = {{3, "", {0, 0, 0}}};
  EXPECT_THROW(render_snapshot(*robot, poses, camera, options), std::invalid_argument);
  Camera blind = camera;
  blind.distance = 0;
  EXPECT_THROW(render_snapshot(*robot, poses, blind, small()), std::invalid_argument);
  blind = camera;
  blind.target.x() = std::nan("");
  EXPECT_THROW(render_snapshot(*robot, poses, blind, small()), std::invalid_argument);
  poses[2].matrix()(0, 0) = std::nan("");
  EXPECT_THROW(render_snapshot(*robot, poses, camera, small()), WorkError);
}

TEST_F(Snapshot, RobotsOfAnySizeAreDrawnAlike) {
  // The same arm a thousand times larger: the same picture but for the floor's squares.
  const auto box = [](const std::string& side) {
    return Robot::from_urdf_text(R"(<robot name="b"><link name="w"/><link name="l">
      <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
      <visual><geometry><box size=")" +
                                     side + " " + side + " " + side + R"("/></geometry></visual></link>
      <joint name="j" type="continuous"><parent link="w"/><child link="l"/><axis xyz="0 0 1"/></joint></robot>)",
                                 "test");
  };
  Image first;
  for (const char* side : {"1", "1000", "0.01"}) {
    const auto robot = box(side);
    const std::vector<std::vector<Eigen::Isometry3d>> poses{test::link_poses(*robot, {0.3})};
    const Image image = render_snapshot(*robot, poses[0], fit_camera(*robot, poses), small());
    if (first.rgb.empty()) first = image;
    EXPECT_LT(compare_images(first, image, 2).share_of_pixels_over_tolerance, 0.01) << side;
  }
}

TEST_F(Snapshot, EnginesAgreePixelByPixel) {
  const auto robot = test::robot(test::kArm);
  const std::vector<std::vector<double>> states{
      {0, 0, 0}, {0.4, 0.7, -1.1}, {-0.9, -0.6, 2.5}, {1.0, 0.99, 0.123456789}};
  std::vector<std::vector<Eigen::Isometry3d>> own;
  for (const auto& q : states) own.push_back(test::link_poses(*robot, q));
  const Camera camera = fit_camera(*robot, own);
  int compared = 0;
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (!info.available) continue;
    const auto dynamics = engine->build(robot, Eigen::Vector3d(0, 0, -9.81));
    for (std::size_t i = 0; i < states.size(); ++i) {
      std::vector<Eigen::Isometry3d> bodies;
      dynamics->body_poses(states[i], bodies);
      const Image image = render_snapshot(*robot, robot->link_poses(bodies), camera, small());
      // The referee is the forward kinematics of this test: engines that agree with it agree with each other.
      const Image referee = render_snapshot(*robot, own[i], camera, small());
      const ImageDifference difference = compare_images(referee, image, kEngineRoundingLevel);
      EXPECT_LE(difference.max_channel, kEngineChannelTolerance)
          << info.name << ", state " << i << ", at " << difference.x << ", " << difference.y;
      EXPECT_LE(difference.share_of_pixels_over_tolerance, kEngineEdgeShare) << info.name << ", state " << i;
      ++compared;
    }
  }
  EXPECT_GE(compared, static_cast<int>(states.size())) << "featherstone is always there";
}

}  // namespace
}  // namespace lacuna
