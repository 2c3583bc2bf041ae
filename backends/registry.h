// The engines Lacuna is built with: a folder and a line here for each.
#pragma once

#include "backends/engine.h"

namespace lacuna {

/// Every engine, in the order of engines().
#define LACUNA_ENGINES(engine) \
  engine(featherstone) engine(mujoco) engine(simbody) engine(ode) engine(bullet) engine(dart)

// featherstone_engine() and so on. Each is defined once, by its engine or, where the package is missing, by what
// cmake/engines.cmake writes to stand in for it.
#define LACUNA_DECLARE(name) const Engine& name##_engine();
LACUNA_ENGINES(LACUNA_DECLARE)
#undef LACUNA_DECLARE

}  // namespace lacuna
