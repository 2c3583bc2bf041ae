// The engines Lacuna is built with: one folder and one line here for each.
#pragma once

#include "backends/engine.h"

namespace lacuna {

// Each is defined once, by its engine or by the stub that stands in for it where the package is missing.
const Engine& featherstone_engine();
const Engine& mujoco_engine();
const Engine& simbody_engine();
const Engine& ode_engine();

}  // namespace lacuna
