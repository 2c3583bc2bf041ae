// The measured quantities: one row each.
#pragma once

#include <vector>

#include "physics/stage.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// How a quantity is had from a plant.
enum class PredictedBy {
  given,       ///< not at all: it drives the plant
  motion,      ///< simulated, as its transducer reads it; in inverse dynamics it is where everything starts
  effort,      ///< what the drive gives the joint, simulated or by inverse dynamics
  drive_side,  ///< the actuator's side of a transmission, simulated or by the effort that bends it
  chambers     ///< simulated where the joint's actuator has chambers; elsewhere not compared, and a note says so
};

struct Quantity {
  ChannelKind kind;
  const char* unit;         ///< of a revolute joint; "": that of the joint's command
  const char* linear_unit;  ///< of a prismatic joint
  Stage stage;              ///< of the chain from command to reading; a measured one cuts the chain there
  PredictedBy predicted_by;
  const char* meaning;
};

/// Every ChannelKind once, in the enumeration's order.
const std::vector<Quantity>& quantity_table();
inline const Quantity& quantity_of(ChannelKind kind) { return quantity_table()[static_cast<std::size_t>(kind)]; }

}  // namespace lacuna
