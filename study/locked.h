// Joints that stand locked are fixed: a plant of fewer bodies that moves alike and costs less.
#pragma once

#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace lacuna {

struct LockedScenario {
  Scenario scenario;  ///< the robot without the locked joints, their links welded where they stand at q = 0
  std::vector<std::string> fixed;  ///< joints that were locked; empty: nothing was changed
};

/// A joint counts as locked where exact dry friction of at least 1e5 N m (N) holds it and nothing else is there: no
/// actuator, no other effect, no channel. Parameters that no longer move anything (masses of links that now belong to
/// the world) are taken out of `identify`. A scenario with a known total mass is returned as it is: there such masses
/// count.
LockedScenario with_locked_joints_fixed(const Scenario& scenario);

}  // namespace lacuna
