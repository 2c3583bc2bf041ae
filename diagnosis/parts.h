// A machine taken apart: joints that cannot move each other are separate problems.
//
// What sits on different branches of a tree whose base stands still shares no force. Along a chain, a drive that gives
// a flow through stiff oil moves its joint whatever the load: with the others fixed the joint's prediction is the same
// but for little beside what is missing there. Each part is diagnosed alone: that is faster, and what is said of one
// joint does not hang on how many others there are. Effects of the whole arm have no place in a part; they are looked
// for on the machine put together again (missing_physics.h).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// The scenario of each part in which a position is measured, named after its first joint; `plain`: the model as
/// identified on the context's recordings. Empty where the machine is in one piece: fewer than two such parts, an
/// effect on the whole arm, or a known total mass.
std::vector<Scenario> parts_of(const Scenario& scenario, const CurrentModel& plain, const FitContext& context);

/// `whole`, a plain model as identified, as far as it is about the part.
CurrentModel part_of(const CurrentModel& whole, const Experiment& experiment, const Scenario& part,
                     const Experiment& part_experiment);

/// `whole` with the effects, values and weights of its parts' models put in: not fitted, its residual and sensitivities
/// evaluated at that point. What no part searched stays.
CurrentModel put_together(const CurrentModel& whole, const std::vector<CurrentModel>& parts,
                          const std::vector<Experiment>& part_experiments, const FitContext& context);

}  // namespace lacuna
