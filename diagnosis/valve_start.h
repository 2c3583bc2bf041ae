// Where the search of a machine with one pump for several valves begins: all its valves and the pump together.
//
// A valve's dead zone hides what a pump at its limit does (without it the gain seems to grow with the command), and the
// pump's limit what the valves of other joints do: one at a time neither is found. Together they can be read off the
// recordings: the speed of a cylinder over the command held rises from the edge of its dead zone in proportion, and
// levels off where the pump gives all it has.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/hypothesis.h"

namespace lacuna {

/// v = gain sgn(u) min(max(|u| - edge, 0), full), as read off windows in which one command is held.
struct ValveReading {
  double gain = 0.0;  ///< rad/s (m/s) per unit of the command
  double edge = 0.0;  ///< units of the command
  double full = 0.0;  ///< beyond the edge: where the speed levels off; as far as the commands went: it does not
  bool levels = false;
};

/// Of joint j on the train windows, those in which no other joint is commanded if they tell enough; by least absolute
/// errors, since a joint may also stand at its stop. Nothing where fewer than three sizes of command were held.
std::optional<ValveReading> read_valve(const Experiment& experiment, int j);

/// `from` with a dead zone at every driven joint whose actuator is a flow, and the pump that they share, at the numbers
/// that were read off; not fitted. Nothing where the pump is not offered (candidates.h), something of this stands
/// already, or fewer than two valves can be read.
struct ValvesWithPump {
  Hypothesis set;
  std::vector<EffectSpec> rivals;  ///< one of each member, in the same order: what it could be instead
  std::vector<std::vector<double>> rivals_own;
};
std::optional<ValvesWithPump> valves_with_pump(const Hypothesis& from, const Experiment& experiment);

}  // namespace lacuna
