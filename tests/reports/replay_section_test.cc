#include "reports/replay_section.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "backends/engine.h"
#include "render/figure.h"
#include "render/pistons.h"
#include "scenarios/robot.h"
#include "tests/reports/sample.h"
#include "tests/scenarios/mesh_writer.h"

namespace lacuna {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using PageData = nlohmann::ordered_json;

Scenario scenario_of(const char* urdf) {
  Scenario out;
  out.robot = Robot::from_urdf(std::string(LACUNA_SOURCE_DIR) + "/scenarios/" + urdf);
  return out;
}

Replay replay_of(const Robot& robot) {
  Replay out{"test_1.csv", Role::test, {}, {}};
  for (const Joint& joint : robot.joints()) out.traces.push_back(sample::trace(joint.name));
  return out;
}

PageData data_of(const Html& html) {
  const std::string open = "class=\"replay-data\">";
  const std::size_t at = html.markup.find(open);
  if (at == std::string::npos) return nullptr;
  const std::size_t begin = at + open.size();
  return PageData::parse(html.markup.substr(begin, html.markup.find('<', begin) - begin));
}

Isometry3d pose_of(const PageData& numbers) {
  Isometry3d out = Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) out.matrix()(i % 3, i / 3) = numbers.at(static_cast<std::size_t>(i)).get<double>();
  return out;
}

/// World poses of the bodies, from the page's data alone: what reports/page/figure.js does.
std::vector<Isometry3d> poses_of(const PageData& joints, const std::vector<double>& q) {
  std::vector<Isometry3d> out;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const PageData& joint = joints[i];
    const int parent = joint["parent"].get<int>();
    const Vector3d axis(joint["axis"][0].get<double>(), joint["axis"][1].get<double>(), joint["axis"][2].get<double>());
    Isometry3d motion = Isometry3d::Identity();
    if (joint["slides"].get<bool>())
      motion.translation() = axis * q[i];
    else
      motion.linear() = Eigen::AngleAxisd(q[i], axis).toRotationMatrix();
    out.push_back((parent < 0 ? Isometry3d::Identity() : out[parent]) * pose_of(joint["origin"]) * motion);
  }
  return out;
}

// Six digits of metres.
constexpr double kRounding = 2e-5;

TEST(ReplaySection, SolidsStandWhereTheSnapshotsHaveThem) {
  for (const char* urdf :
       {"hydrolek/hydrolek.urdf", "cartpole/cartpole.urdf", "double_pendulum/double_pendulum.urdf"}) {
    const Scenario scenario = scenario_of(urdf);
    const Robot& robot = *scenario.robot;
    const std::vector<Replay> replays{replay_of(robot)};
    const PageData data = data_of(replay_section(scenario, replays, {}));
    std::vector<double> q;
    for (int i = 0; i < robot.dof(); ++i) q.push_back(0.3 - 0.1 * i);
    std::vector<Isometry3d> bodies;
    find_engine("featherstone").build(scenario.robot, scenario.gravity)->body_poses(q, bodies);
    const std::vector<Solid> figure = robot_figure(robot, robot.link_poses(bodies));
    const std::vector<Isometry3d> poses = poses_of(data["joints"], q);
    ASSERT_GE(data["solids"].size(), figure.size()) << urdf;
    for (std::size_t s = 0; s < figure.size(); ++s) {
      const PageData& solid = data["solids"][s];
      const int body = solid["body"].get<int>();
      const Isometry3d pose = (body < 0 ? Isometry3d::Identity() : poses[body]) * pose_of(solid["pose"]);
      EXPECT_LT((pose.translation() - figure[s].pose.translation()).norm(), kRounding) << urdf << ", solid " << s;
      // What is round about its z looks the same however it is turned about it.
      const int first = figure[s].kind == Solid::Kind::box ? 0 : 2;
      for (int axis = first; axis < 3; ++axis)
        EXPECT_LT((pose.linear().col(axis) - figure[s].pose.linear().col(axis)).norm(), kRounding)
            << urdf << ", solid " << s << ", axis " << axis;
    }
  }
}

TEST(ReplaySection, CylindersHangOnTheirPinsInEveryPose) {
  const Scenario scenario =
      load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/hydrolek/hydraulic/scenario.yaml");
  const Robot& robot = *scenario.robot;
  const std::vector<Replay> replays{replay_of(robot)};
  const PageData solids = data_of(replay_section(scenario, replays, {}))["solids"];
  const std::vector<double> q{0.2, 0.6, -0.9, 0.1, 0.3, 0.0, 0.04};
  std::vector<Isometry3d> bodies;
  find_engine("featherstone").build(scenario.robot, scenario.gravity)->body_poses(q, bodies);
  const std::vector<Isometry3d> links = robot.link_poses(bodies);
  const std::vector<Piston> pistons = pistons_of(scenario);
  ASSERT_EQ(pistons.size(), 3u) << "joints 2, 3 and 5 turn by levers";
  std::size_t at = solids.size() - 4 * pistons.size();
  for (const Piston& piston : pistons) {
    const std::vector<Solid> parts = piston_figure(robot, links, piston);
    for (const std::size_t k : {2, 3}) {
      const PageData& pin = solids[at + k];
      const int body = pin["body"].get<int>();
      EXPECT_EQ(body, k == 2 ? robot.joints()[piston.joint].parent : piston.joint);
      const Isometry3d pose = (body < 0 ? Isometry3d::Identity() : bodies[body]) * pose_of(pin["pose"]);
      EXPECT_LT((pose.translation() - parts[k].pose.translation()).norm(), kRounding) << piston.joint << ", pin " << k;
    }
    for (const std::size_t k : {0, 1}) {
      EXPECT_EQ(solids[at + k]["between"], PageData::array({at + 2, at + 3}));
      EXPECT_NEAR(solids[at + k]["barrel"].get<double>(), 2.0 * parts[0].half.z(), kRounding);
    }
    at += 4;
  }
}

TEST(ReplaySection, HoldsWhatWasMeasuredAndHowFarTheModelsAreOff) {
  const Scenario scenario = scenario_of("double_pendulum/double_pendulum.urdf");
  const std::vector<Replay> replays{replay_of(*scenario.robot)};
  const PageData recording = data_of(replay_section(scenario, replays, {"plain", "found"}))["recordings"][0];
  EXPECT_EQ(recording["name"], "test_1.csv");
  EXPECT_EQ(recording["role"], "test");
  EXPECT_LE(recording["time"]["d"].size(), kMostFrames);
  const PageData& before = recording["joints"][1]["before"];
  EXPECT_NEAR(before["from"].get<double>() + before["step"].get<double>() * before["d"][0].get<double>(), 0.01, 1e-6);
}

TEST(ReplaySection, IsLeftOutWhereNoPositionsAreComparedOrTheClockRunsBack) {
  Scenario scenario = scenario_of("double_pendulum/double_pendulum.urdf");
  std::vector<Replay> replays{replay_of(*scenario.robot)};
  EXPECT_TRUE(replay_section(scenario, {}, {}).markup.empty());
  EXPECT_TRUE(replay_section(Scenario{}, replays, {}).markup.empty());
  std::swap(replays[0].traces[0].time[3], replays[0].traces[0].time[4]);
  EXPECT_TRUE(replay_section(scenario, replays, {}).markup.empty());
  replays = {replay_of(*scenario.robot)};
  scenario.prediction = InverseDynamics{40.0};
  EXPECT_TRUE(replay_section(scenario, replays, {}).markup.empty());
}

TEST(ReplaySection, AJointThatIsNotMeasuredStandsAtZero) {
  const Scenario scenario = scenario_of("hydrolek/hydrolek.urdf");
  std::vector<Replay> replays{replay_of(*scenario.robot)};
  replays[0].traces.resize(2);
  const PageData data = data_of(replay_section(scenario, replays, {}));
  EXPECT_EQ(data["joints"].size(), static_cast<std::size_t>(scenario.robot->dof()));
  EXPECT_EQ(data["recordings"][0]["joints"].size(), 2u);
}

/// A robot whose every link with visuals is the mesh.
Scenario meshed(const Mesh& mesh) {
  Scenario out = scenario_of("hydrolek/hydrolek.urdf");
  auto links = out.robot->links();
  const auto shared = std::make_shared<const Mesh>(mesh);
  for (Link& link : links)
    for (Visual& visual : link.visuals) visual.shape = Visual::Shape::mesh, visual.size.setZero(), visual.mesh = shared;
  out.robot = std::make_shared<const Robot>("meshed", out.robot->joints(), links, "test");
  return out;
}

TEST(ReplaySection, CarriesMeshesInWholeStepsOfTheirBox) {
  const Mesh box = test::box_mesh({0.1f, 0, 0}, {0.2f, 0.4f, 0.1f});
  const Scenario scenario = meshed(box);
  const Html html = replay_section(scenario, std::vector{replay_of(*scenario.robot)}, {});
  const PageData data = data_of(html);
  std::size_t meshes = 0;
  for (const PageData& solid : data["solids"]) {
    if (solid["kind"] != "mesh") continue;
    ++meshes;
    ASSERT_EQ(solid["vertices"].size(), 24u);
    ASSERT_EQ(solid["triangles"].size(), 36u);
    for (std::size_t i = 0; i < 24; ++i) {
      const double half = solid["half"][i % 3].get<double>(), steps = solid["steps"].get<double>();
      const double middle = 0.5 * (box.lower + box.upper)[static_cast<Eigen::Index>(i % 3)];
      EXPECT_NEAR(middle + half * (2 * solid["vertices"][i].get<double>() / steps - 1),
                  box.vertices[i / 3][static_cast<Eigen::Index>(i % 3)], kRounding);
    }
  }
  EXPECT_GT(meshes, 0u);
  EXPECT_EQ(html.markup.find("coarser"), std::string::npos);
}

TEST(ReplaySection, LargeMeshesAreMadeCoarserAndThePageSaysSo) {
  const Scenario scenario = meshed(test::ball_mesh(0.3f, 100));
  const Html html = replay_section(scenario, std::vector{replay_of(*scenario.robot)}, {});
  std::size_t triangles = 0;
  const PageData data = data_of(html);
  for (const PageData& solid : data["solids"])
    if (solid["kind"] == "mesh") triangles += solid["triangles"].size() / 3;
  EXPECT_GT(triangles, kMostTriangles / 8);
  EXPECT_LE(triangles, kMostTriangles);
  EXPECT_NE(html.markup.find("The meshes are drawn coarser here"), std::string::npos);
  EXPECT_LT(html.markup.size(), 500'000u) << "what the header promises, and the recording";
}

}  // namespace
}  // namespace lacuna
