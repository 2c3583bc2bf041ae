// The scenarios that come with the project, and the shared data where it is present.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "scenarios/scenario.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios";

/// World poses of the bodies at q = 0.
std::vector<Eigen::Isometry3d> stretched(const Robot& robot) {
  std::vector<Eigen::Isometry3d> poses;
  for (const Joint& joint : robot.joints())
    poses.push_back(joint.parent < 0 ? joint.origin : poses[joint.parent] * joint.origin);
  return poses;
}

bool carries(const Robot& robot, int joint, int body) {
  while (body > joint) body = robot.joints()[body].parent;
  return body == joint;
}

/// Everything joint `joint` moves at q = 0, in its own frame.
Inertial carried(const Robot& robot, int joint) {
  const auto poses = stretched(robot);
  Inertial sum;
  for (int body = joint; body < robot.dof(); ++body)
    if (carries(robot, joint, body))
      sum = welded(sum, robot.body_inertial(body).seen_from(poses[joint].inverse() * poses[body]));
  return sum;
}

/// Torque of gravity on revolute joint `joint` at q = 0, N m.
double gravity_torque(const Robot& robot, int joint) {
  const auto pose = stretched(robot)[joint];
  const Inertial load = carried(robot, joint);
  const Eigen::Vector3d weight = pose.linear().transpose() * Eigen::Vector3d(0, 0, -9.81 * load.mass);
  return std::abs(robot.joints()[joint].axis.dot(load.com.cross(weight)));
}

double inertia_about(const Robot& robot, int joint) {
  const Inertial load = carried(robot, joint);
  const Eigen::Vector3d axis = robot.joints()[joint].axis;
  return axis.dot(load.inertia * axis) + load.mass * axis.cross(load.com).squaredNorm();
}

TEST(Bundled, TheArmHasTheCheckFiguresOfItsDescription) {
  const auto robot = Robot::from_urdf(kFolder / "hydrolek" / "hydrolek.urdf");
  EXPECT_EQ(robot->dof(), 7);
  EXPECT_NEAR(robot->moving_mass(), 42.6, 1e-12);
  // Printed to whole newton metres and two or three digits of inertia.
  EXPECT_NEAR(gravity_torque(*robot, 1), 256.0, 0.5);
  EXPECT_NEAR(gravity_torque(*robot, 2), 82.0, 0.5);
  EXPECT_NEAR(gravity_torque(*robot, 4), 15.0, 0.5);
  EXPECT_NEAR(inertia_about(*robot, 1), 21.3, 0.05);
  EXPECT_NEAR(inertia_about(*robot, 2), 4.2, 0.05);
}

TEST(Bundled, TheGripperOpensTenCentimetresWithMassOutOfLink6) {
  const auto robot = Robot::from_urdf(kFolder / "hydrolek" / "hydrolek.urdf");
  const Joint& jaw = robot->joints().at(6);
  EXPECT_EQ(jaw.name, "joint_7");
  EXPECT_TRUE(jaw.prismatic());
  EXPECT_EQ(jaw.lower, 0.0);
  EXPECT_EQ(jaw.upper, 0.10);
  EXPECT_EQ(jaw.axis, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(robot->body_inertial(5).mass + robot->body_inertial(6).mass, 4.7, 1e-12);
  EXPECT_EQ(robot->tool().body, 5);
  EXPECT_EQ(robot->tool().point, Eigen::Vector3d(0.16, 0, 0));
}

TEST(Bundled, SeedArmsCarryTheMassesOfTheirTables) {
  const std::vector<std::pair<const char*, std::vector<double>>> tables{
      {"seed_table1", {4.6, 5.1, 22.5, 1.6, 4.1, 4.7}},
      {"seed_table5", {5.8, 12.7, 6.9, 7.75, 8.31, 4.2}},
      {"seed_start", {0.6, 1.3, 2.8, 1.2, 2.2, 1.7}}};
  for (const auto& [name, masses] : tables) {
    const auto robot = Robot::from_urdf(kFolder / "hydrolek" / (std::string(name) + ".urdf"));
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(robot->body_inertial(static_cast<int>(i)).mass, masses[i]) << name;
  }
}

TEST(Bundled, EveryScenarioFileLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kFolder)) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    EXPECT_NO_THROW(load_scenario(entry.path(), {.load_recordings = false})) << entry.path();
  }
  EXPECT_GE(count, 9);
}

TEST(Bundled, PresetBoundsHoldBothTruthsAndDoNotStartAtOne) {
  for (const char* table : {"table1", "table5"}) {
    const auto folder = kFolder / "hydrolek";
    const std::string name = std::string("joint_2_") + table;
    const Scenario start = load_scenario(folder / (name + ".yaml"), {.load_recordings = false});
    const Scenario truth = load_scenario(folder / name / "truth.yaml", {.load_recordings = false});
    ASSERT_EQ(start.identify.size(), 9u);
    for (const IdentifySpec& spec : start.identify) {
      const auto dot = spec.name.find('.');
      const std::string owner = spec.name.substr(0, dot), parameter = spec.name.substr(dot + 1);
      const auto value = [&](const Scenario& s) {
        if (parameter == "mass") return s.robot->links()[*s.robot->find_link(owner)].inertial.mass;
        return s.actuators.front().parameters.at(parameter);  // joint 2 has the only one
      };
      EXPECT_GT(value(truth), spec.lower) << name << ' ' << spec.name;
      EXPECT_LT(value(truth), spec.upper) << name << ' ' << spec.name;
      EXPECT_NE(value(truth), value(start)) << name << ' ' << spec.name;
    }
  }
}

TEST(Bundled, CommandsCoverTheRangeInTwentySeconds) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder / "hydrolek")) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("commands_", 0) != 0) continue;
    ++count;
    const auto data = load_recording(entry.path(), name);
    EXPECT_EQ(data->rows(), 2000u) << name;
    EXPECT_EQ(data->columns[0].back(), 19.99) << name;
    for (std::size_t c = 1; c < data->columns.size(); ++c) {
      const auto [low, high] = std::minmax_element(data->columns[c].begin(), data->columns[c].end());
      EXPECT_LT(*low, -2.5) << name << c;
      EXPECT_GT(*high, 2.5) << name << c;
      EXPECT_LE(std::max(-*low, *high), 7.0) << name << c;
    }
  }
  EXPECT_EQ(count, 8);
}

TEST(SharedData, EveryScenarioLoadsAndSavesToTheSameRecordings) {
  const auto shared = test::shared_data();
  if (!shared) GTEST_SKIP() << "no shared data at $LACUNA_DATA or ../shared";
  const test::TemporaryFolder folder;
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*shared)) {
    if (entry.path().extension() != ".yaml") continue;
    const Scenario s = load_scenario(entry.path());
    EXPECT_FALSE(s.recordings.empty());
    if (count++ % 8 != 0) continue;
    save_scenario(s, folder.path() / "again.yaml");
    EXPECT_EQ(load_scenario(folder.path() / "again.yaml").recordings.size(), s.recordings.size());
  }
  EXPECT_GT(count, 0);
}

TEST(SharedData, ExcavatorLoggerThatStopsInMidLineIsCounted) {
  const auto shared = test::shared_data();
  if (!shared) GTEST_SKIP() << "no shared data at $LACUNA_DATA or ../shared";
  const Scenario s = load_scenario(*shared / "recordings" / "excavator" / "scenario.yaml");
  EXPECT_THAT(s.notes, testing::Contains(testing::HasSubstr("run_01.csv: 3 missing values")));
  EXPECT_FALSE(s.sample_period);
  EXPECT_EQ(s.channels.of.at(ChannelKind::command).at("boom").offset, -7.5);
}

TEST(SharedData, TheProjectsArmAgreesWithTheReferenceArm) {
  const auto shared = test::shared_data();
  if (!shared) GTEST_SKIP() << "no shared data at $LACUNA_DATA or ../shared";
  const auto reference = Robot::from_urdf(*shared / "robots" / "hydrolek.urdf");
  const auto ours = Robot::from_urdf(kFolder / "hydrolek" / "seed_table1.urdf");
  ASSERT_EQ(ours->dof(), reference->dof());
  for (int i = 0; i < ours->dof(); ++i) {
    const Inertial a = ours->body_inertial(i), b = reference->body_inertial(i);
    EXPECT_NEAR(a.mass, b.mass, 1e-12);
    EXPECT_NEAR((a.com - b.com).norm(), 0.0, 1e-12);
    EXPECT_NEAR((a.inertia - b.inertia).norm(), 0.0, 2e-4) << "the reference is rounded to four decimals";
    const Joint &p = ours->joints()[i], &q = reference->joints()[i];
    EXPECT_EQ(p.name, q.name);
    EXPECT_TRUE(p.origin.isApprox(q.origin, 1e-12));
    EXPECT_NEAR((p.axis - q.axis).norm(), 0.0, 1e-12);
    EXPECT_NEAR(std::min(p.upper, 10.0), std::min(q.upper, 10.0), 1e-5);
  }
}

}  // namespace
}  // namespace lacuna
