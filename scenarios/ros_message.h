// What is read out of the messages of ROS 2: states of joints, commands and forces, as named numbers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/cdr.h"

namespace lacuna {

/// One number: `<topic>/<part>/<quantity>`, or `<topic>/<quantity>[index]`. The texts are views of the message.
struct RosField {
  std::string_view part;      ///< the joint; empty where the message has none
  std::string_view quantity;  ///< "position"
  int index = -1;             ///< of an array
  double value = 0.0;         ///< NaN where the message leaves it out
};

/// Names, or values of an array, in one message; more are refused before they are kept.
inline constexpr std::size_t kMaxRosFields = 4096;

struct RosMessage {
  bool stamped = false;       ///< the message has a header
  std::int64_t stamp_ns = 0;  ///< of the header, ns since its clock's epoch; 0: not filled in
  std::vector<RosField> fields;
  std::size_t points_ignored = 0;  ///< of a trajectory, beyond its first
};

/// A type of message that is understood.
struct RosType {
  const char* name;  ///< "sensor_msgs/msg/JointState"
  bool command;      ///< what it says holds until the next message
  bool state;        ///< a topic of this type makes the recording's clock, where none is named
  void (*decode)(CdrReader& reader, RosMessage& out);
};

/// nullptr where the type is none of those.
const RosType* find_ros_type(std::string_view name);
std::vector<std::string> ros_type_names();

/// Replaces `out`, whose memory is used again. Throws MessageFault. What follows the known fields is left unread:
/// types grow at their end.
void decode_ros_message(const RosType& type, std::string_view message, RosMessage& out);

}  // namespace lacuna
