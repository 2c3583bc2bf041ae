// URDF text of a robot, for other tools and for reading back.
#pragma once

#include <span>
#include <string>

#include "scenarios/robot.h"

namespace lacuna {

/// As to_urdf (scenarios/scenario.h), with comments at its head.
std::string commented_urdf(const Robot& robot, std::span<const double> link_masses,
                           std::span<const std::string> comments);

}  // namespace lacuna
