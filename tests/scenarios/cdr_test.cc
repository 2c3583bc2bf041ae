#include "scenarios/cdr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "scenarios/ros_message.h"
#include "tests/scenarios/bag_writer.h"

namespace lacuna {
namespace {

using test::CdrWriter;
using testing::HasSubstr;

/// A message together with the bytes that its names are views of.
struct Decoded : RosMessage {
  std::shared_ptr<const std::string> bytes;
};

Decoded decoded(const std::string& type, const std::string& bytes) {
  const RosType* known = find_ros_type(type);
  if (known == nullptr) throw std::runtime_error("no such type");
  Decoded out;
  out.bytes = std::make_shared<const std::string>(bytes);
  decode_ros_message(*known, *out.bytes, out);
  return out;
}

/// What the message's refusal says was found.
std::string fault(const std::string& type, const std::string& bytes) {
  try {
    decoded(type, bytes);
  } catch (const MessageFault& refused) {
    return refused.found;
  }
  ADD_FAILURE() << "no MessageFault";
  return "";
}

std::string names_of(const RosMessage& message) {
  std::string out;
  for (const RosField& field : message.fields) {
    out += std::string(field.part) + "/" + std::string(field.quantity);
    if (field.index >= 0) out += "[" + std::to_string(field.index) + "]";
    out += " ";
  }
  return out;
}

std::vector<double> values_of(const RosMessage& message) {
  std::vector<double> out;
  for (const RosField& field : message.fields) out.push_back(field.value);
  return out;
}

/// Written out byte by byte from OMG's rules: strings with their NUL and its count, every number aligned to its own
/// size from the end of the encapsulation.
TEST(Cdr, ReadsAJointStateWrittenByHandInEitherByteOrder) {
  const std::string little(
      "\x00\x01\x00\x00"                  // plain CDR, little endian
      "\x05\x00\x00\x00\x00\xCA\x9A\x3B"  // stamp: 5 s and 1,000,000,000 ns
      "\x02\x00\x00\x00w\x00\x00\x00"     // frame "w", two bytes of padding
      "\x01\x00\x00\x00"                  // one name
      "\x02\x00\x00\x00"
      "a\x00\x00\x00"                      // "a", padded
      "\x01\x00\x00\x00"                   // one position
      "\x00\x00\x00\x00\x00\x00\xF8\x3F"   // 1.5: at offset 32, a multiple of 8
      "\x00\x00\x00\x00"                   // no velocity
      "\x01\x00\x00\x00"                   // one effort
      "\x00\x00\x00\x00\x00\x00\x00\xC0",  // -2.0: at offset 48
      4 + 56);
  const std::string big(
      "\x00\x00\x00\x00"
      "\x00\x00\x00\x05\x3B\x9A\xCA\x00"
      "\x00\x00\x00\x02w\x00\x00\x00"
      "\x00\x00\x00\x01"
      "\x00\x00\x00\x02"
      "a\x00\x00\x00"
      "\x00\x00\x00\x01"
      "\x3F\xF8\x00\x00\x00\x00\x00\x00"
      "\x00\x00\x00\x00"
      "\x00\x00\x00\x01"
      "\xC0\x00\x00\x00\x00\x00\x00\x00",
      4 + 56);
  for (const std::string& bytes : {little, big}) {
    const Decoded message = decoded("sensor_msgs/msg/JointState", bytes);
    EXPECT_TRUE(message.stamped);
    EXPECT_EQ(message.stamp_ns, 5'000'000'000 + 1'000'000'000);
    EXPECT_EQ(names_of(message), "a/position a/velocity a/effort ");
    EXPECT_EQ(message.fields[0].value, 1.5);
    EXPECT_TRUE(std::isnan(message.fields[1].value));
    EXPECT_EQ(message.fields[2].value, -2.0);
  }
}

TEST(Cdr, ReadsCommandsArraysForcesAndPressures) {
  EXPECT_EQ(values_of(decoded("std_msgs/msg/Float64", CdrWriter().f64(3.25).bytes())), std::vector<double>{3.25});
  EXPECT_EQ(values_of(decoded("std_msgs/msg/Float32", CdrWriter().f32(0.5f).bytes())), std::vector<double>{0.5});
  const Decoded array = decoded("std_msgs/msg/Float64MultiArray", test::float64_array({1, -2, 3}));
  EXPECT_EQ(names_of(array), "/data[0] /data[1] /data[2] ");
  EXPECT_EQ(values_of(array), (std::vector<double>{1, -2, 3}));
  const Decoded floats =
      decoded("std_msgs/msg/Float32MultiArray", CdrWriter().u32(0).u32(0).u32(2).f32(1.5f).f32(2.5f).bytes());
  EXPECT_EQ(values_of(floats), (std::vector<double>{1.5, 2.5}));
  const Decoded wrench = decoded("geometry_msgs/msg/WrenchStamped",
                                 CdrWriter().header(7).f64(1).f64(2).f64(3).f64(4).f64(5).f64(6).bytes());
  EXPECT_EQ(names_of(wrench), "force/x force/y force/z torque/x torque/y torque/z ");
  EXPECT_EQ(values_of(wrench), (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(wrench.stamp_ns, 7);
  const Decoded pressure = decoded("sensor_msgs/msg/FluidPressure", CdrWriter().header(7).f64(2e7).f64(0).bytes());
  EXPECT_EQ(names_of(pressure), "/fluid_pressure ");
}

TEST(Cdr, ReadsTheFirstPointOfATrajectoryAndCountsTheOthers) {
  CdrWriter writer;
  writer.header(0).texts({"a", "b"}).u32(2);
  for (const double x : {1.0, 9.0})
    writer.numbers({x, -x}).numbers({}).numbers({}).numbers({10 * x, 20 * x}).i32(0).u32(5);
  const Decoded message = decoded("trajectory_msgs/msg/JointTrajectory", writer.bytes());
  EXPECT_EQ(message.points_ignored, 1u);
  EXPECT_EQ(message.fields[0].value, 1.0);
  EXPECT_EQ(message.fields[1].value, -1.0);
  EXPECT_EQ(message.fields[7].value, 20.0);
  EXPECT_EQ(names_of(message).substr(0, 22), "a/position b/position ");
}

TEST(Cdr, ReadsInterfacesByTheirOwnNames) {
  const std::string bytes = CdrWriter()
                                .header(1)
                                .texts({"boom", "stick"})
                                .u32(2)
                                .texts({"position", "pressure_a"})
                                .numbers({0.5, 2e7})
                                .texts({"position"})
                                .numbers({0.25})
                                .bytes();
  const Decoded message = decoded("control_msgs/msg/DynamicJointState", bytes);
  EXPECT_EQ(names_of(message), "boom/position boom/pressure_a stick/position ");
  EXPECT_EQ(values_of(message), (std::vector<double>{0.5, 2e7, 0.25}));
  const Decoded command =
      decoded("control_msgs/msg/MultiDOFCommand", CdrWriter().texts({"x"}).numbers({4}).numbers({}).bytes());
  EXPECT_EQ(command.fields[0].value, 4.0);
}

/// Whatever is cut off, the end is noticed, and nothing beyond it is read (sanitizers watch).
TEST(Cdr, NoticesEveryPlaceWhereAMessageMayEnd) {
  const std::string whole = test::joint_state(5, {"shoulder", "elbow"}, {1, 2}, {3, 4}, {5, 6});
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_FALSE(fault("sensor_msgs/msg/JointState", whole.substr(0, bytes)).empty()) << bytes;
}

TEST(Cdr, RefusesOtherFormsLyingCountsAndUnevenJoints) {
  EXPECT_THAT(fault("std_msgs/msg/Float64", std::string("\x00\x07\x00\x00\0\0\0\0\0\0\0\0", 12)), HasSubstr("0x0007"));
  EXPECT_THAT(fault("std_msgs/msg/Float64MultiArray", CdrWriter().u32(0).u32(0).u32(0xFFFFFFFF).bytes()),
              HasSubstr("4294967295 elements"));
  EXPECT_THAT(fault("sensor_msgs/msg/JointState", test::joint_state(0, {"a", "b"}, {1})),
              HasSubstr("1 values of position"));
  EXPECT_THAT(fault("sensor_msgs/msg/JointState", CdrWriter().i32(0).u32(0).u32(3).bytes()),
              HasSubstr("a text of 3 bytes"));
  std::string open = CdrWriter().header(0).texts({"a"}).bytes();
  open.back() = 'x';
  EXPECT_THAT(fault("sensor_msgs/msg/JointState", open), HasSubstr("without its closing NUL"));
  EXPECT_THAT(fault("std_msgs/msg/Float64MultiArray", test::float64_array(std::vector<double>(5000))),
              HasSubstr("5000 values"));
}

}  // namespace
}  // namespace lacuna
