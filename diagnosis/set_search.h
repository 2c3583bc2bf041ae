// Where the findings of the rounds (rounds.h) leave a rest beyond the noise: the search goes on with sets of effects.
//
// On a real machine several effects sit at every joint and none alone explains much. So at every place the effect that
// promises most is put in, all places together, and the set is fitted whole; if that is refused each goes in alone,
// then with others of its place on the same part of the way from command to reading. Numbers that members hold at their
// neutral values are freed, and what joints share is tried in place of limits that they seemed to have of their own. A
// set stays if it has more evidence than the one before it and the validate recordings do not speak against it
// (hypothesis.h). What was added at
// a joint must together remove a quarter of what the findings before left above the noise there, as a single effect
// must (decide.h). What the recordings show of valves directly goes in first, each joint's curve as a whole. At last
// every member is held against the set without it and against each rival in its place, all fitted, over blocks of the
// recordings drawn again; what the validate recordings do not confirm, or what may as well be of no strength, stays in
// the model and is no finding.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/valve_start.h"

namespace lacuna {

struct SetSearchResult {
  CurrentModel model;
  std::vector<Finding> findings;
  std::vector<std::vector<Candidate>> rounds;
  std::vector<std::string> notes;
  double step = 0.0;  ///< s, that the model needs
};

struct SetSearchOptions {
  std::uint64_t seed = 1;
  std::function<void(double done)> progress = {};
  std::function<bool(const EffectSpec&)> skipped = {};  ///< what is not put in
  std::vector<ValveStart> valves = {};                  ///< put in first, each joint's whole
  /// What stands at the start was judged by searches of its own: it goes only where nothing asks for it any more.
  bool judged = false;
};

/// From `current`, whose effects beyond those of `plain` are those of `findings`, in order. Nothing where these stand
/// as they are, or no validate recording is there to prove anything on.
std::optional<SetSearchResult> search_sets(const CurrentModel& plain, const CurrentModel& current,
                                           const std::vector<Finding>& findings, const FitContext& context,
                                           const SetSearchOptions& options);

/// Joints whose residual on the recordings that were not fitted is beyond their noise: with that noise, else by colour.
bool leaves_a_rest(const CurrentModel& current, const FitContext& context);

}  // namespace lacuna
