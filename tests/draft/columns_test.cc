#include "draft/columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "draft/names.h"

namespace lacuna {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Axis {
  std::string joint, link, type = "revolute";
};

/// A chain of these joints.
std::shared_ptr<const Robot> chain(const std::vector<Axis>& axes) {
  std::string xml = "<robot name='chain'><link name='ground'/>", parent = "ground";
  for (const Axis& axis : axes) {
    xml += "<link name='" + axis.link +
           "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>";
    xml += "<joint name='" + axis.joint + "' type='" + axis.type + "'><parent link='" + parent + "'/><child link='" +
           axis.link + "'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='10' velocity='10'/></joint>";
    parent = axis.link;
  }
  return Robot::from_urdf_text(xml + "</robot>", "chain");
}

const std::vector<Axis> kUr{{"shoulder_pan_joint", "shoulder_link"}, {"shoulder_lift_joint", "upper_arm_link"},
                            {"elbow_joint", "forearm_link"},         {"wrist_1_joint", "wrist_1_link"},
                            {"wrist_2_joint", "wrist_2_link"},       {"wrist_3_joint", "wrist_3_link"}};
const std::vector<Axis> kNumbered{{"joint_1", "link_1"}, {"joint_2", "link_2"}, {"joint_3", "link_3"}};
const std::vector<Axis> kDigger{{"boom", "boom_link"}, {"stick", "stick_link"}, {"bucket", "bucket_link"}};

std::string column_of(const ColumnGuesses& guesses, ChannelKind kind, int joint) {
  const ColumnGuess* guess = guesses.find(kind, joint);
  return guess == nullptr ? "" : guess->column;
}

std::string why_unused(const ColumnGuesses& guesses, const std::string& column) {
  for (const UnusedColumn& unused : guesses.unused)
    if (unused.column == column) return unused.reason;
  return "";
}

TEST(Names, AreCutIntoWords) {
  EXPECT_THAT(words_of("shoulderPan_q2[deg]"), ElementsAre("shoulder", "pan", "q", "2", "deg"));
  EXPECT_THAT(words_of("/joint_states/elbow/POS02"), ElementsAre("joint", "states", "elbow", "pos", "2"));
  EXPECT_THAT(words_of("..--"), IsEmpty());
  EXPECT_THAT(words_of(""), IsEmpty());
  EXPECT_THAT(words_of("0"), ElementsAre("0"));
  EXPECT_LE(words_of(std::string(10'000, 'a') + std::string(10'000, '.')).size(), kMostWords);
}

TEST(Columns, NumbersAreTheRobotsOrderWhereItsNamesHaveOtherOnes) {
  const auto robot = chain(kUr);
  const ColumnGuesses found = match_columns(*robot, {"t", "q1", "q2", "q3", "q4", "q5", "q6", "qd1", "qd2", "qd3",
                                                     "qd4", "qd5", "qd6", "i1", "i2", "i3", "i4", "i5", "i6"});
  EXPECT_EQ(found.time, "t");
  EXPECT_THAT(found.unused, IsEmpty());
  ASSERT_EQ(found.columns.size(), 18u);
  for (int j = 0; j < 6; ++j) {
    const std::string number = std::to_string(j + 1);
    EXPECT_EQ(column_of(found, ChannelKind::position, j), "q" + number);
    EXPECT_EQ(column_of(found, ChannelKind::velocity, j), "qd" + number);
    EXPECT_EQ(column_of(found, ChannelKind::effort, j), "i" + number);
    EXPECT_TRUE(found.find(ChannelKind::effort, j)->current);
    EXPECT_FALSE(found.find(ChannelKind::position, j)->sure);
    EXPECT_THAT(found.find(ChannelKind::position, j)->reason, HasSubstr("order"));
  }
}

TEST(Columns, NumbersInJointNamesAreTheirs) {
  // In another order than the robot's.
  const auto robot = chain({{"joint_2", "link_2"}, {"joint_1", "link_1"}});
  const ColumnGuesses found = match_columns(*robot, {"time_s", "u_1", "u_2", "q_1", "q_2"});
  EXPECT_EQ(found.time, "time_s");
  EXPECT_EQ(found.time_unit, "s");
  EXPECT_EQ(column_of(found, ChannelKind::command, 0), "u_2");
  EXPECT_EQ(column_of(found, ChannelKind::position, 1), "q_1");
  EXPECT_TRUE(found.find(ChannelKind::position, 1)->sure);
}

TEST(Columns, CountingFromZeroIsSeen) {
  const ColumnGuesses found = match_columns(*chain(kNumbered), {"t", "q_0", "q_1", "q_2", "tau_1", "tau_2", "tau_3"});
  for (int j = 0; j < 3; ++j) {
    EXPECT_EQ(column_of(found, ChannelKind::position, j), "q_" + std::to_string(j));
    EXPECT_EQ(column_of(found, ChannelKind::effort, j), "tau_" + std::to_string(j + 1));
  }
}

TEST(Columns, FullNamesAndRosNamesAreFound) {
  const ColumnGuesses found =
      match_columns(*chain(kUr), {"timestamp", "position.shoulder_lift_joint", "velocity.elbow_joint",
                                  "effort.wrist_2_joint", "/joint_states/wrist_1_joint/position", "forearm_angle_deg"});
  EXPECT_EQ(found.time, "timestamp");
  EXPECT_EQ(column_of(found, ChannelKind::position, 1), "position.shoulder_lift_joint");
  EXPECT_EQ(column_of(found, ChannelKind::velocity, 2), "velocity.elbow_joint");
  EXPECT_EQ(column_of(found, ChannelKind::effort, 4), "effort.wrist_2_joint");
  EXPECT_EQ(column_of(found, ChannelKind::position, 3), "/joint_states/wrist_1_joint/position");
  ASSERT_EQ(column_of(found, ChannelKind::position, 2), "forearm_angle_deg");
  EXPECT_EQ(found.find(ChannelKind::position, 2)->unit, "deg");
  EXPECT_THAT(found.find(ChannelKind::position, 2)->reason, HasSubstr("link"));
}

TEST(Columns, TheLastNameBelongsToTheLastJointAsAGuess) {
  const ColumnGuesses found =
      match_columns(*chain(kDigger), {"t", "u_boom", "u_arm", "u_bucket", "q_boom", "q_arm", "q_bucket", "boom_head",
                                      "boom_rod", "arm_head", "arm_rod", "bucket_head", "bucket_rod", "pilot_arm_in"});
  EXPECT_EQ(column_of(found, ChannelKind::command, 1), "u_arm");
  EXPECT_EQ(column_of(found, ChannelKind::position, 1), "q_arm");
  EXPECT_FALSE(found.find(ChannelKind::position, 1)->sure);
  EXPECT_EQ(column_of(found, ChannelKind::pressure_a, 0), "boom_head");
  EXPECT_EQ(column_of(found, ChannelKind::pressure_b, 2), "bucket_rod");
  EXPECT_EQ(column_of(found, ChannelKind::pressure_a, 1), "arm_head");
  EXPECT_NE(why_unused(found, "pilot_arm_in"), "");
}

TEST(Columns, WhatWasAskedForIsNoMeasurement) {
  const ColumnGuesses found =
      match_columns(*chain({{"slide", "carriage", "prismatic"}}), {"t", "q_ref", "q", "u", "force", "acc"});
  EXPECT_EQ(column_of(found, ChannelKind::position, 0), "q");
  EXPECT_EQ(column_of(found, ChannelKind::command, 0), "u");
  EXPECT_EQ(column_of(found, ChannelKind::effort, 0), "force");
  EXPECT_THAT(why_unused(found, "q_ref"), HasSubstr("asked for"));
  EXPECT_THAT(why_unused(found, "acc"), HasSubstr("acceleration"));
}

TEST(Columns, UnitsInNamesAreNoQuantities) {
  const auto robot = chain({{"elbow", "forearm"}});
  const ColumnGuesses found =
      match_columns(*robot, {"t_ms", "elbow_cmd_v", "v_elbow", "elbow_torque_cmd", "elbow_deg"});
  EXPECT_EQ(found.time_unit, "ms");
  EXPECT_EQ(column_of(found, ChannelKind::command, 0), "elbow_cmd_v");
  EXPECT_EQ(found.find(ChannelKind::command, 0)->unit, "v");
  EXPECT_EQ(column_of(found, ChannelKind::velocity, 0), "v_elbow");
  EXPECT_EQ(column_of(found, ChannelKind::position, 0), "elbow_deg");
  EXPECT_THAT(why_unused(found, "elbow_torque_cmd"), HasSubstr("elbow_cmd_v"));
}

TEST(Columns, WhatBelongsToNoJointIsAskedFor) {
  const ColumnGuesses found = match_columns(*chain(kUr), {"t", "q_left", "temperature"});
  EXPECT_THAT(found.columns, IsEmpty());
  ASSERT_EQ(found.unused.size(), 2u);
  EXPECT_TRUE(found.unused[0].asks);
  EXPECT_FALSE(found.unused[1].asks);
}

TEST(Columns, NoColumnIsTakenTwiceAndNoneIsLost) {
  const std::vector<std::string> names{"t", "q_1", "q_01", "pos_1", "joint_1", "", "\x01", "q_1_ref", "1", "q", "u_4"};
  const ColumnGuesses found = match_columns(*chain(kNumbered), names);
  EXPECT_EQ(found.columns.size() + found.unused.size() + 1, names.size());
  EXPECT_EQ(column_of(found, ChannelKind::position, 0), "q_1");
}

TEST(Columns, OfABagAreMatchedByTopicJointAndPlaceInAnArray) {
  const auto robot = chain(kDigger);
  const ColumnGuesses found =
      match_columns(*robot, {"time", "/controller/joint_trajectory/boom/position", "/joint_states/boom/position",
                             "/joint_states/boom/velocity", "/joint_states/bucket/position",
                             "/joint_states/stick/position", "/valve_commands/data[0]", "/valve_commands/data[1]",
                             "/valve_commands/data[2]", "/valve_commands/data[3]"});
  EXPECT_EQ(found.time, "time");
  EXPECT_EQ(column_of(found, ChannelKind::position, 0), "/joint_states/boom/position");
  EXPECT_EQ(column_of(found, ChannelKind::velocity, 0), "/joint_states/boom/velocity");
  EXPECT_EQ(column_of(found, ChannelKind::position, 2), "/joint_states/bucket/position");
  EXPECT_EQ(column_of(found, ChannelKind::command, 0), "/valve_commands/data[0]");
  EXPECT_EQ(column_of(found, ChannelKind::command, 2), "/valve_commands/data[2]");
  EXPECT_FALSE(found.find(ChannelKind::command, 2)->sure);
  EXPECT_THAT(found.find(ChannelKind::command, 2)->reason, HasSubstr("place in the array"));
  EXPECT_THAT(why_unused(found, "/controller/joint_trajectory/boom/position"), HasSubstr("what was asked for"));
  EXPECT_THAT(why_unused(found, "/valve_commands/data[3]"), HasSubstr("of which joint"));
  const ColumnUse use = use_of(found);
  EXPECT_EQ(use.commands.size(), 3u);
  EXPECT_EQ(use.measured.count("/joint_states/stick/position"), 1u);
}

}  // namespace
}  // namespace lacuna
