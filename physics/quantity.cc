#include "physics/quantity.h"

namespace lacuna {

const std::vector<Quantity>& quantity_table() {
  static const std::vector<Quantity> table = {
      {ChannelKind::command, "", "", Stage::command, PredictedBy::given, "what the joint's actuator is told"},
      {ChannelKind::position, "rad", "m", Stage::reading, PredictedBy::motion, "the joint's position"},
      {ChannelKind::velocity, "rad/s", "m/s", Stage::reading, PredictedBy::motion, "the joint's speed"},
      {ChannelKind::effort, "N m", "N", Stage::effort, PredictedBy::effort, "what the drive gives the joint"},
      {ChannelKind::motor_position, "rad", "m", Stage::transmission, PredictedBy::drive_side,
       "the actuator's side of the transmission, in the joint's coordinate"},
      {ChannelKind::pressure_a, "Pa", "Pa", Stage::flow, PredictedBy::chambers, "pressure that pushes the joint up"},
      {ChannelKind::pressure_b, "Pa", "Pa", Stage::flow, PredictedBy::chambers, "pressure that pushes the joint down"}};
  return table;
}

}  // namespace lacuna
