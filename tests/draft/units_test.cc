#include "draft/units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "draft/clock.h"
#include "draft/roles.h"

namespace lacuna {
namespace {

using testing::HasSubstr;

constexpr double kDegreeInRad = std::numbers::pi / 180.0;

std::shared_ptr<const Robot> two_joints() {
  return Robot::from_urdf_text(R"(<robot name='r'><link name='a'/>
  <link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='c'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='turn' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='9' velocity='9'/></joint>
  <joint name='slide' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='1 0 0'/><limit lower='0' upper='0.4' effort='9' velocity='9'/></joint>
  </robot>)",
                               "r");
}

Recording recording(const std::vector<std::string>& names, const std::vector<std::vector<double>>& columns) {
  Recording out;
  out.names = names, out.columns = columns;
  return out;
}

UnitGuess position_unit(const std::string& name, std::vector<double> values) {
  const auto robot = two_joints();
  const Recording data = recording({"t", name}, {std::vector<double>(values.size(), 0.0), values});
  const ColumnGuesses guesses = match_columns(*robot, data.names);
  return guess_position_unit(*robot, guesses, guesses.columns.at(0), {&data});
}

TEST(Clock, UnitIsTheOneInWhichTheRateMakesSense) {
  const auto clock = [](double step, const std::string& said = "") {
    std::vector<double> time;
    for (int i = 0; i < 50; ++i) time.push_back(step * i);
    return guess_clock(time, said);
  };
  EXPECT_EQ(clock(0.01).unit, "s");
  EXPECT_TRUE(clock(0.01).sure);
  EXPECT_EQ(clock(10).unit, "ms");
  EXPECT_FALSE(clock(10).sure);
  EXPECT_DOUBLE_EQ(clock(10).period, 0.01);
  EXPECT_EQ(clock(10'000).unit, "us");
  EXPECT_EQ(clock(1e7).unit, "ns");
  EXPECT_EQ(clock(2, "s").unit, "s");  // who says so is believed
  EXPECT_TRUE(clock(10, "ms").sure);
}

TEST(Clock, EvenIsWithinOnePercent) {
  EXPECT_TRUE(guess_clock({0, 0.01, 0.02, 0.03005}, "").even);
  EXPECT_FALSE(guess_clock({0, 0.01, 0.02, 0.0302}, "").even);
}

TEST(Units, AnglesBeyondTheLimitsAreDegrees) {
  EXPECT_EQ(position_unit("q_turn", {-1.0, 2.9}).scale, 1.0);
  const UnitGuess degrees = position_unit("q_turn", {-10.0, 95.0});
  EXPECT_DOUBLE_EQ(degrees.scale, kDegreeInRad);
  EXPECT_FALSE(degrees.sure);
  EXPECT_THAT(degrees.text, HasSubstr("95"));
  // Small degrees look like rad: only the name can tell.
  EXPECT_EQ(position_unit("q_turn", {0.0, 2.0}).scale, 1.0);
  EXPECT_DOUBLE_EQ(position_unit("q_turn_deg", {0.0, 2.0}).scale, kDegreeInRad);
}

TEST(Units, SlidesBeyondTheLimitsAreMillimetres) {
  EXPECT_EQ(position_unit("q_slide", {0.0, 0.4}).scale, 1.0);
  EXPECT_EQ(position_unit("q_slide", {0.0, 390.0}).scale, 1e-3);
  EXPECT_EQ(position_unit("q_slide_cm", {0.0, 0.1}).scale, 1e-2);
}

TEST(Units, SpeedsFollowThePositions) {
  const auto robot = two_joints();
  const Joint& turn = robot->joints()[0];
  std::vector<double> time, q, v;
  for (int i = 0; i < 300; ++i)
    time.push_back(0.01 * i), q.push_back(std::sin(time.back())), v.push_back(std::cos(time.back()));
  const auto guess = [&](double factor) {
    std::vector<double> column = v;
    for (double& x : column) x *= factor;
    return guess_velocity_unit(turn, {}, time, q, column);
  };
  EXPECT_EQ(guess(1.0).scale, 1.0);
  EXPECT_TRUE(guess(1.0).sure);
  EXPECT_DOUBLE_EQ(guess(1.0 / kDegreeInRad).scale, kDegreeInRad);
  EXPECT_DOUBLE_EQ(guess(30.0 / std::numbers::pi).scale, std::numbers::pi / 30.0);
  EXPECT_EQ(guess(-1.0).scale, -1.0);
  EXPECT_FALSE(guess(-1.0).sure);
  EXPECT_FALSE(guess(7.0).sure);
  EXPECT_THAT(guess(7.0).text, HasSubstr("not clear"));
}

TEST(Roles, AreTakenFromNamesWhereTheseSayThem) {
  const RoleGuesses roles = guess_roles(
      {{"a/test_1.csv", {0, 1}, {0, 0}}, {"train_1.csv", {0, 1}, {0, 0}}, {"validate.csv", {0, 1}, {0, 0}}});
  ASSERT_EQ(roles.roles.size(), 3u);
  EXPECT_EQ(roles.roles[0].role, Role::test);
  EXPECT_EQ(roles.roles[1].role, Role::train);
  EXPECT_EQ(roles.roles[2].role, Role::validate);
}

TEST(Roles, OneRecordingIsCutAtRest) {
  RecordingSpan span{"run.csv", {}, {}};
  for (int i = 0; i <= 1000; ++i) {
    span.time.push_back(0.01 * i);
    span.speed.push_back(i > 515 && i < 525 ? 0.0 : 1.0);
  }
  const RoleGuesses roles = guess_roles({span});
  ASSERT_EQ(roles.roles.size(), 3u);
  EXPECT_EQ(roles.roles[0].role, Role::train);
  EXPECT_NEAR(roles.roles[0].to.value(), 5.2, 0.05);
  EXPECT_EQ(roles.roles[1].from, roles.roles[0].to);
  EXPECT_EQ(roles.roles[2].from, roles.roles[1].to);
  EXPECT_NEAR(roles.roles[2].from.value(), 7.5, 0.51);
}

TEST(Roles, WhatIsTooShortIsNotSplit) {
  const RoleGuesses roles = guess_roles({{"run.csv", {0, 1, 2}, {0, 0, 0}}});
  ASSERT_EQ(roles.roles.size(), 1u);
  EXPECT_EQ(roles.roles[0].role, Role::train);
  EXPECT_FALSE(roles.roles[0].to.has_value());
}

TEST(Roles, EveryRoleIsTakenByAnyNumberOfRecordings) {
  for (std::size_t n = 1; n <= 12; ++n) {
    std::vector<double> time(100), speed(100, 0.0);
    for (std::size_t i = 0; i < time.size(); ++i) time[i] = 0.01 * static_cast<double>(i);
    std::vector<RecordingSpan> spans(n, RecordingSpan{"run.csv", time, speed});
    int count[3] = {};
    std::vector<bool> used(n, false);
    for (const RoleGuess& role : guess_roles(spans).roles)
      ++count[static_cast<int>(role.role)], used[role.recording] = true;
    for (const int each : count) EXPECT_GT(each, 0) << n;
    EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool each) { return each; })) << n;
  }
}

}  // namespace
}  // namespace lacuna
