// As much of an experiment as a search needs.
//
// What is missing is looked for by thousands of simulations, whose time grows with the recordings, while a few minutes
// of motion tell most effects apart. So long data cut into windows are searched by some of the windows, spread evenly
// over every recording; what was found is fitted to all of them (missing_physics.h).
#pragma once

#include "physics/experiment.h"

namespace lacuna {

/// Values measured in train segments, all channels, that a search uses at most where windows can be left out.
constexpr std::size_t kMostSearched = 30000;

/// The experiment with the same share of every recording's train and validate segments, at least one of each, so that
/// the train ones hold about `most` values; all of it where they hold no more.
Experiment thinned(const Experiment& experiment, std::size_t most = kMostSearched);

}  // namespace lacuna
