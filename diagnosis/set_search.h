// Where the findings of the rounds (rounds.h) leave a rest beyond the noise: the search goes on with sets of effects.
//
// On a real machine several effects sit at every joint and none alone explains much. So at every place the effect that
// promises most is put in, all places together, and the set is fitted whole; it stays if it has more evidence than the
// set before it and predicts the validate recordings better (hypothesis.h). What the whole set does at a joint is what
// counts: there it must remove at least a quarter of what the findings before it left above the noise, as a single
// effect must (decide.h), else what was added there goes. At last every member is held against the set without it and
// against each rival in its place, all fitted, over blocks of the recordings drawn again.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/hypothesis.h"

namespace lacuna {

struct SetSearchResult {
  CurrentModel model;
  std::vector<Finding> findings;
  std::vector<std::vector<Candidate>> rounds;
  std::vector<std::string> notes;
  SimulatorOptions simulator;  ///< with the step that the model needs
};

struct SetSearchOptions {
  SimulatorOptions simulator;
  RunControl control;
  std::uint64_t seed = 1;
  std::function<void(double done)> progress = {};
};

/// From `current`, whose effects beyond those of `plain` are those of `findings`, in order. Nothing where these stand
/// as they are.
std::optional<SetSearchResult> search_sets(const CurrentModel& plain, const CurrentModel& current,
                                           const std::vector<Finding>& findings, const Experiment& experiment,
                                           const SetSearchOptions& options);

/// Joints whose residual on the recordings that were not fitted is beyond their noise: with that noise, else by colour.
bool leaves_a_rest(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& options);

}  // namespace lacuna
