#include "scenarios/ros_message.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace lacuna {
namespace {

constexpr std::size_t kTextBytes = 4;    ///< of the shortest text
constexpr std::size_t kNumberBytes = 8;  ///< of a float64

/// Length of a sequence that becomes columns; as many as a recording may have at most.
std::size_t column_count(CdrReader& in, std::size_t least) {
  const std::size_t count = in.count(least);
  if (count > kMaxRosFields)
    throw MessageFault(fmt::format("{} values", count), fmt::format("at most {}", kMaxRosFields));
  return count;
}

void read_header(CdrReader& in, RosMessage& out) {
  const std::int64_t seconds = in.int32();
  const std::int64_t nanoseconds = in.uint32();
  in.text();  // frame
  out.stamped = true;
  out.stamp_ns = seconds * 1'000'000'000 + nanoseconds;
}

std::vector<std::string_view> read_names(CdrReader& in) {
  std::vector<std::string_view> names(column_count(in, kTextBytes));
  for (std::string_view& name : names) name = in.text();
  return names;
}

/// One number of `quantity` for every name, or none at all: then it is missing.
void read_numbers(CdrReader& in, const std::vector<std::string_view>& names, std::string_view quantity,
                  RosMessage& out) {
  const std::size_t count = in.count(kNumberBytes);
  if (count != 0 && count != names.size())
    throw MessageFault(fmt::format("{} values of {}", count, quantity),
                       fmt::format("{}, one for each joint, or none", names.size()));
  for (const std::string_view name : names)
    out.fields.push_back({name, quantity, -1, count == 0 ? std::numeric_limits<double>::quiet_NaN() : in.float64()});
}

void joint_state(CdrReader& in, RosMessage& out) {
  read_header(in, out);
  const auto names = read_names(in);
  for (const char* quantity : {"position", "velocity", "effort"}) read_numbers(in, names, quantity, out);
}

/// The first point: controllers that are told one point at a time send no other.
void joint_trajectory(CdrReader& in, RosMessage& out) {
  read_header(in, out);
  const auto names = read_names(in);
  const std::size_t points = in.count(4 * 4 + 8);
  if (points == 0) return;  // "stop here": no command
  out.points_ignored = points - 1;
  for (const char* quantity : {"position", "velocity", "acceleration", "effort"})
    read_numbers(in, names, quantity, out);
}

void multi_dof_command(CdrReader& in, RosMessage& out) {
  const auto names = read_names(in);
  for (const char* quantity : {"value", "value_dot"}) read_numbers(in, names, quantity, out);
}

/// Of each joint (or group) its interfaces by name: what ros2_control's broadcasters publish of any sensor.
void dynamic_state(CdrReader& in, RosMessage& out) {
  read_header(in, out);
  const auto names = read_names(in);
  const std::size_t count = in.count(2 * 4);
  if (count != names.size())
    throw MessageFault(fmt::format("interfaces of {} joints", count), fmt::format("of {}", names.size()));
  for (const std::string_view name : names) {
    const auto interfaces = read_names(in);
    const std::size_t values = in.count(kNumberBytes);
    if (values != interfaces.size())
      throw MessageFault(fmt::format("{} values of {} interfaces", values, interfaces.size()), "one for each");
    for (const std::string_view quantity : interfaces) out.fields.push_back({name, quantity, -1, in.float64()});
    if (out.fields.size() > kMaxRosFields)
      throw MessageFault(fmt::format("{} values and more", out.fields.size()),
                         fmt::format("at most {}", kMaxRosFields));
  }
}

/// std_msgs/MultiArrayLayout: dimensions (label, size, stride) and an offset; the numbers are counted as they come.
void skip_layout(CdrReader& in) {
  const std::size_t dimensions = in.count(3 * 4);
  for (std::size_t d = 0; d < dimensions; ++d) {
    in.text();
    in.uint32(), in.uint32();
  }
  in.uint32();
}

void float64_array(CdrReader& in, RosMessage& out) {
  skip_layout(in);
  const std::size_t count = column_count(in, kNumberBytes);
  for (std::size_t i = 0; i < count; ++i) out.fields.push_back({"", "data", static_cast<int>(i), in.float64()});
}

void float32_array(CdrReader& in, RosMessage& out) {
  skip_layout(in);
  const std::size_t count = column_count(in, 4);
  for (std::size_t i = 0; i < count; ++i) out.fields.push_back({"", "data", static_cast<int>(i), in.float32()});
}

void float64(CdrReader& in, RosMessage& out) { out.fields.push_back({"", "data", -1, in.float64()}); }
void float32(CdrReader& in, RosMessage& out) { out.fields.push_back({"", "data", -1, in.float32()}); }

void wrench(CdrReader& in, RosMessage& out) {
  read_header(in, out);
  for (const char* part : {"force", "torque"})
    for (const char* axis : {"x", "y", "z"}) out.fields.push_back({part, axis, -1, in.float64()});
}

void fluid_pressure(CdrReader& in, RosMessage& out) {
  read_header(in, out);
  out.fields.push_back({"", "fluid_pressure", -1, in.float64()});
}

constexpr std::array kRosTypes{
    RosType{"sensor_msgs/msg/JointState", false, true, &joint_state},
    RosType{"control_msgs/msg/DynamicJointState", false, true, &dynamic_state},
    RosType{"control_msgs/msg/DynamicInterfaceGroupValues", false, false, &dynamic_state},
    RosType{"control_msgs/msg/MultiDOFCommand", true, false, &multi_dof_command},
    RosType{"geometry_msgs/msg/WrenchStamped", false, false, &wrench},
    RosType{"sensor_msgs/msg/FluidPressure", false, false, &fluid_pressure},
    RosType{"std_msgs/msg/Float32", true, false, &float32},
    RosType{"std_msgs/msg/Float32MultiArray", true, false, &float32_array},
    RosType{"std_msgs/msg/Float64", true, false, &float64},
    RosType{"std_msgs/msg/Float64MultiArray", true, false, &float64_array},
    RosType{"trajectory_msgs/msg/JointTrajectory", true, false, &joint_trajectory},
};

}  // namespace

const RosType* find_ros_type(std::string_view name) {
  for (const RosType& type : kRosTypes)
    if (name == type.name) return &type;
  return nullptr;
}

std::vector<std::string> ros_type_names() {
  std::vector<std::string> out;
  for (const RosType& type : kRosTypes) out.emplace_back(type.name);
  return out;
}

void decode_ros_message(const RosType& type, std::string_view message, RosMessage& out) {
  out.stamped = false, out.stamp_ns = 0, out.points_ignored = 0;
  out.fields.clear();
  CdrReader reader(message);
  type.decode(reader, out);
}

}  // namespace lacuna
