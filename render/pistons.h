// The cylinders of a scenario's actuators, as they are drawn.
#pragma once

#include <vector>

#include "render/figure.h"

namespace lacuna {

struct Scenario;

/// Of every hydraulic actuator whose levers and areas are given, in the actuators' order: a barrel a little shorter
/// than the cylinder where it is shortest; bore and rod from the areas of the piston's two faces.
std::vector<Piston> pistons_of(const Scenario& scenario);

}  // namespace lacuna
