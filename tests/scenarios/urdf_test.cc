#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/scenario.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::kRobot;
using test::replaced;
using test::Spoiled;
using testing::AllOf;
using testing::HasSubstr;

std::string urdf_refusal(const std::string& xml) {
  return input_error([&] { Robot::from_urdf_text(xml, "arm.urdf"); });
}

TEST(Urdf, ReadsJointsInTheOrderWrittenParentsFirst) {
  // The child's joint is written first here, and urdfdom itself sorts by name.
  const auto robot = Robot::from_urdf_text(R"(<robot name='r'>
    <link name='z'/><link name='m'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>
    <link name='a'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>
    <joint name='j1' type='continuous'><parent link='m'/><child link='a'/><axis xyz='0 0 1'/></joint>
    <joint name='j2' type='continuous'><parent link='z'/><child link='m'/><axis xyz='0 3 4'/></joint></robot>)",
                                           "arm.urdf");
  ASSERT_EQ(robot->dof(), 2);
  EXPECT_EQ(robot->joints()[0].name, "j2");
  EXPECT_EQ(robot->joints()[1].parent, 0);
  EXPECT_NEAR((robot->joints()[0].axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 0.0, 1e-15) << "made a unit vector";
}

TEST(Urdf, FoldsFixedJointsAndTurnsInertialFrames) {
  const auto robot = Robot::from_urdf_text(R"(<robot name='r'>
    <link name='world'/><link name='stand'/>
    <link name='arm'><inertial><origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/><mass value='2'/><inertia ixx='1' ixy='0' ixz='0' iyy='2' iyz='0' izz='2.5'/></inertial></link>
    <link name='flange'><inertial><mass value='1'/><inertia ixx='.1' ixy='0' ixz='0' iyy='.1' iyz='0' izz='.1'/></inertial></link>
    <joint name='bolt' type='fixed'><parent link='world'/><child link='stand'/><origin xyz='0 0 1'/></joint>
    <joint name='turn' type='revolute'><parent link='stand'/><child link='arm'/><origin xyz='0 0 2'/><limit lower='-1' upper='1' effort='5' velocity='6'/></joint>
    <joint name='weld' type='fixed'><parent link='arm'/><child link='flange'/><origin xyz='3 0 0'/></joint></robot>)",
                                           "arm.urdf");
  ASSERT_EQ(robot->dof(), 1);
  EXPECT_EQ(robot->links().size(), 4u);
  EXPECT_EQ(robot->joints()[0].parent, -1);
  EXPECT_EQ(robot->joints()[0].origin.translation(), Eigen::Vector3d(0, 0, 3));
  EXPECT_EQ(robot->joints()[0].axis, Eigen::Vector3d::UnitX()) << "URDF's default axis";
  EXPECT_NEAR(robot->links()[2].inertial.inertia(0, 0), 2.0, 1e-12) << "x and y exchanged by the rotation";
  const Inertial body = robot->body_inertial(0);
  EXPECT_DOUBLE_EQ(body.mass, 3.0);
  EXPECT_NEAR(body.com[0], (2.0 * 1 + 1.0 * 3) / 3, 1e-15);
}

TEST(Urdf, NotesWhatItIgnores) {
  std::vector<std::string> notes;
  std::string xml =
      replaced(kRobot, "<origin xyz='1 0 0'/>", "<origin xyz='1 0 0'/><mimic joint='a'/><dynamics damping='1'/>");
  Robot::from_urdf_text(xml, "arm.urdf", &notes);
  EXPECT_THAT(notes, testing::UnorderedElementsAre(HasSubstr("mimic"), HasSubstr("<dynamics>")));
}

TEST(Urdf, MeshesAreNamedAndNotOpened) {
  const auto robot = Robot::from_urdf_text(replaced(kRobot, "<link name='base'/>",
                                                    "<link name='base'><visual><geometry><mesh filename='none/x.stl' "
                                                    "scale='1 2 .5'/></geometry></visual></link>"),
                                           "arm.urdf");
  const Visual& visual = robot->links()[*robot->find_link("base")].visuals.at(0);
  EXPECT_EQ(visual.mesh_file, "none/x.stl");
  EXPECT_EQ(visual.mesh_scale, Eigen::Vector3d(1, 2, 0.5));
  EXPECT_FALSE(visual.drawn());
}

TEST(Urdf, WhatIsWrittenReadsBack) {
  const auto robot = Robot::from_urdf(std::string(LACUNA_SOURCE_DIR) + "/scenarios/hydrolek/hydrolek.urdf");
  const auto back = Robot::from_urdf_text(to_urdf(*robot), "back.urdf");
  ASSERT_EQ(back->dof(), robot->dof());
  for (int i = 0; i < robot->dof(); ++i) {
    EXPECT_EQ(back->joints()[i].name, robot->joints()[i].name);
    EXPECT_EQ(back->joints()[i].axis, robot->joints()[i].axis);
    EXPECT_TRUE(back->joints()[i].origin.isApprox(robot->joints()[i].origin, 1e-15));
    EXPECT_EQ(back->body_inertial(i).inertia, robot->body_inertial(i).inertia);
    EXPECT_EQ(back->body_inertial(i).com, robot->body_inertial(i).com);
    EXPECT_EQ(back->joints()[i].upper, robot->joints()[i].upper);
  }
  EXPECT_EQ(back->tool().point, robot->tool().point);
}

TEST(Urdf, WritesTheMassesGiven) {
  const auto robot = Robot::from_urdf_text(kRobot, "arm.urdf");
  const auto heavy = Robot::from_urdf_text(to_urdf(*robot, std::vector<double>{0.0, 4.0, 1.0}), "back.urdf");
  EXPECT_DOUBLE_EQ(heavy->moving_mass(), 5.0);
  EXPECT_NEAR(heavy->links()[1].inertial.inertia(1, 1), 0.4, 1e-15);
}

TEST(Urdf, WritesRotationsAndNamesThatNeedEscapes) {
  const std::string name = "a&lt;&amp;&quot;&apos;";
  std::string xml = replaced(kRobot, "<joint name='b'", "<joint name='" + name + "'");
  xml = replaced(xml, "<origin xyz='1 0 0'/>", "<origin xyz='1 0 0' rpy='0.3 1.2 -2.5'/>");
  const auto robot = Robot::from_urdf_text(xml, "arm.urdf");
  const auto back = Robot::from_urdf_text(to_urdf(*robot), "back.urdf");
  EXPECT_EQ(back->joints()[1].name, "a<&\"'");
  EXPECT_TRUE(back->joints()[1].origin.isApprox(robot->joints()[1].origin, 1e-14));
}

class SpoiledUrdf : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledUrdf, IsRefusedWithLineAndReason) {
  EXPECT_THAT(urdf_refusal(replaced(kRobot, GetParam().from, GetParam().to)), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Urdf, SpoiledUrdf,
    testing::Values(
        Spoiled{"ZeroMass", "mass value='1'", "mass value='0'",
                "arm.urdf:7: link lower: mass: found 0, expected a mass above 0 kg"},
        Spoiled{"NegativeMass", "mass value='1'", "mass value='-2.5'", "arm.urdf:7: link lower: mass: found -2.5"},
        Spoiled{"MassIsNoNumber", "mass value='1'", "mass value='heavy'",
                "arm.urdf:8: <mass> value: found \"heavy\", expected a finite number"},
        Spoiled{"MassIsInfinite", "mass value='1'", "mass value='inf'", "found \"inf\", expected a finite number"},
        Spoiled{"MassIsNan", "mass value='1'", "mass value='nan'", "found \"nan\", expected a finite number"},
        Spoiled{"MassTooLargeForADouble", "mass value='1'", "mass value='1e999'",
                "found \"1e999\", expected a finite number"},
        Spoiled{"NoMass", "<mass value='1'/>", "", "arm.urdf:8: found <inertial> without <mass>"},
        Spoiled{"NoInertia", "<inertia ixx='0.01' ixy='0' ixz='0' iyy='0.05' iyz='0' izz='0.05'/>", "",
                "without <inertia>"},
        Spoiled{"InertiaLacksAnEntry", "iyy='0.05' iyz='0' izz='0.05'", "iyy='0.05' iyz='0'", "<inertia> without izz"},
        Spoiled{"TriangleInequality", "iyy='0.05'", "iyy='0.5'",
                "arm.urdf:7: link lower: inertia: found principal moments 0.01, 0.05 and 0.5"},
        Spoiled{"NegativeInertia", "ixx='0.01' ixy='0' ixz='0' iyy='0.05'", "ixx='-0.01' ixy='0' ixz='0' iyy='0.05'",
                "none below 0"},
        Spoiled{"TwoNumbersForThree", "xyz='1 0 0'", "xyz='1 0'", "found \"1 0\", expected 3 finite numbers"},
        Spoiled{"FloatingJoint", "name='b' type='revolute'", "name='b' type='floating'",
                "arm.urdf:11: joint b: type: found \"floating\", expected revolute, continuous, prismatic or fixed"},
        Spoiled{"PlanarJoint", "name='b' type='revolute'", "name='b' type='planar'", "found \"planar\""},
        Spoiled{"JointTwice", "joint name='b'", "joint name='a'", "arm.urdf:11: found the joint \"a\" twice"},
        Spoiled{"LinkTwice", "link name='lower'", "link name='upper'", "arm.urdf:7: found the link \"upper\" twice"},
        Spoiled{"NoSuchLink", "child link='lower'", "child link='lowest'",
                "joint b: child: found the link \"lowest\", which does not exist, expected base, upper or lower"},
        Spoiled{"TwoParents", "<parent link='upper'/><child link='lower'/>",
                "<parent link='base'/><child link='upper'/>", "as the child of a second joint"},
        Spoiled{"Cycle", "<parent link='base'/><child link='upper'/>", "<parent link='lower'/><child link='upper'/>",
                "cycle"},
        Spoiled{"TwoRoots", "<link name='base'/>", "<link name='base'/><link name='other'/>",
                "link other: found a second link without a parent"},
        Spoiled{"ZeroAxis", "<origin xyz='1 0 0'/><axis xyz='0 -1 0'/>", "<origin xyz='1 0 0'/><axis xyz='0 0 0'/>",
                "joint b: axis: found length 0"},
        Spoiled{"NoLimit", "<limit lower='-2' upper='2' effort='50' velocity='1'/>", "",
                "arm.urdf:11: joint b: found no <limit>"},
        Spoiled{"LimitsReversed", "<limit lower='-2' upper='2' effort='50'", "<limit lower='2' upper='-2' effort='50'",
                "joint b: limit: found lower 2 above upper -2"},
        Spoiled{"NoRobot", "<robot name='two'>", "<machine name='two'>", "</robot>"},
        Spoiled{"SecondInertial", "<link name='upper'>",
                "<link name='upper'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
                "izz='1'/></inertial>",
                "a second <inertial>"},
        Spoiled{"AttributeTwice", "mass value='1'", "mass value='1' value='2'",
                "the attribute \"value\" a second time"},
        Spoiled{"TagNotClosed", "</link>", "", "arm.urdf"},
        Spoiled{"Doctype", "<?xml version='1.0'?>", "<!DOCTYPE robot [<!ENTITY a 'b'>]>",
                "arm.urdf:1: found a declaration"},
        Spoiled{"NotUtf8", "name='base'", "name='b\xff'", "arm.urdf:3: found the byte 0xff"},
        Spoiled{"SecondRoot", "</robot>", "</robot><robot name='c'/>", "a second root"}),
    [](const auto& test) { return std::string(test.param.name); });

/// Found by scripts/fuzz: urdfdom's reader ends a declaration elsewhere than ours, and finds the robot within it.
TEST(Urdf, OfWhichReadersMakeDifferentRobotsIsRefused) {
  EXPECT_THAT(urdf_refusal("<?xml version=\"\n1\"A>\n<robot name='a'><link name='x'/></robot>?>\n<!-- c -->"
                           "<?xml version=\"\n1\"?>\n<robot name='b'><link name='y'/></robot>"),
              testing::HasSubstr("readers make different robots"));
}

TEST(Urdf, MovedLinkWithoutMassIsRefused) {
  EXPECT_THAT(urdf_refusal(replaced(kRobot, "<link name='lower'>", "<link name='lower'/><link name='x'>")),
              AllOf(HasSubstr("arm.urdf"), HasSubstr("link x")));
}

TEST(Urdf, DeepNestingIsRefusedBeforeAnyoneRecurses) {
  std::string xml = "<robot name='r'>";
  for (int i = 0; i < 200'000; ++i) xml += "<a>";
  EXPECT_THAT(urdf_refusal(xml), HasSubstr("levels of nesting"));
}

TEST(Urdf, EmptyAndMissingFilesAreNamed) {
  const test::TemporaryFolder folder;
  const auto empty = folder.write("empty.urdf", "");
  EXPECT_THAT(input_error([&] { Robot::from_urdf(empty); }),
              AllOf(HasSubstr("empty.urdf"), HasSubstr("an empty file")));
  EXPECT_THAT(input_error([&] { Robot::from_urdf(folder.path() / "none.urdf"); }),
              AllOf(HasSubstr("none.urdf"), HasSubstr("no such file")));
  EXPECT_THAT(input_error([&] { Robot::from_urdf(folder.path()); }), HasSubstr("a folder"));
  EXPECT_THAT(input_error([&] { Robot::from_urdf("/dev/zero"); }), HasSubstr("a device"));
}

}  // namespace
}  // namespace lacuna
