// A machine taken apart: joints that cannot move each other are separate problems.
//
// What sits on different branches of a tree whose base stands still shares no force. Each branch is diagnosed alone:
// that is faster, and what is said of one joint does not hang on how many others there are. Effects of the whole arm
// have no place in a part; they are looked for on the machine put together again (missing_physics.h).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// The scenario of each branch in which a position is measured, named after its first joint. Empty where the machine
/// is in one piece: fewer than two such branches, an effect on the whole arm, or a known total mass.
std::vector<Scenario> parts_of(const Scenario& scenario);

/// `whole`, a plain model as identified, as far as it is about the part.
CurrentModel part_of(const CurrentModel& whole, const Experiment& experiment, const Scenario& part,
                     const Experiment& part_experiment);

/// `whole` with the effects, values and weights of its parts' models put in: not fitted, its residual and sensitivities
/// evaluated at that point. Values of joints that are in no part stay.
CurrentModel put_together(const CurrentModel& whole, const Experiment& experiment,
                          const std::vector<CurrentModel>& parts, const std::vector<Experiment>& part_experiments,
                          const SimulatorOptions& simulator);

}  // namespace lacuna
