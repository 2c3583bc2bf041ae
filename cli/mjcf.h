// A plant as MuJoCo's own format, for users of MuJoCo. Nothing here needs MuJoCo.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "physics/plant_model.h"

namespace lacuna {

/// MJCF of the plant with these values: bodies with their identified mass properties, joints with damping, spring and
/// dry friction, one actuator per driven joint whose control is the recording's command. What the format cannot hold
/// (delay, dead zone, soft saturation, break-away friction) stands in comments.
std::string to_mjcf(const PlantModel& model, std::span<const double> values);

/// Actuators and effects in words, one each, for formats that hold none of them.
std::vector<std::string> plant_in_words(const PlantModel& model, std::span<const double> values);

}  // namespace lacuna
