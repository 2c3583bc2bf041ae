// As much of an experiment as a search needs.
//
// What is missing is looked for by thousands of simulations, whose time grows with the recordings, while a few minutes
// of motion tell most effects apart. So long data cut into windows are searched by some of the windows; what was found
// is fitted to all of them (missing_physics.h). Which: a minute of one command held says little more than two seconds
// of it do, and the two seconds in which a valve opens come once. So windows of every kind are kept alike, where a kind
// is a recording and, for each joint, about how far its command goes either way within the window; windows in which
// nothing is commanded are of one kind in all recordings.
#pragma once

#include "physics/experiment.h"

namespace lacuna {

/// Values measured in train segments, all channels, that a search uses at most where windows can be left out.
constexpr std::size_t kMostSearched = 50000;

/// The experiment with train and validate segments left out so that the train ones hold about `most` values, and of
/// the validate ones the same share is left; at least one of each of every recording. Of each kind as many are kept as
/// of any other, or all there are, spread evenly over them; all of it where train segments hold no more than `most`.
Experiment thinned(const Experiment& experiment, std::size_t most = kMostSearched);

}  // namespace lacuna
