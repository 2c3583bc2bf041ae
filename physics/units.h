// Units of numbers as one scenario has them: the tables write them for a revolute joint and a command in volts.
#pragma once

#include <string>

#include "scenarios/scenario.h"

namespace lacuna {

/// What nothing says more of: "the command's own unit".
inline constexpr const char* kAnyCommand = "cmd";

/// Unit of a joint's command: as its channel states it; where the command is the effort (`direct_effort` of gain 1)
/// that of the effort; else kAnyCommand.
std::string command_unit(const Scenario& scenario, const std::string& joint);

/// A unit of the tables ("N m/V", "rad") at a joint: linear in place of angular at a slide, `command` in place of
/// volts: "N m/%", "rad/(s A)"; "1" where both cancel.
std::string unit_at(const std::string& unit, bool prismatic, const std::string& command);

}  // namespace lacuna
