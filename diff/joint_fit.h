// Both sets of recordings fitted together in full simulation: some numbers common, some apart.
#pragma once

#include "diff/side.h"

namespace lacuna {

struct JointFit {
  std::vector<double> a, b;  ///< search points
  double cost = HUGE_VAL;    ///< both residuals' squares and the priors', train recordings
  int iterations = 0;
};

/// Groups of changeable numbers as indices of their coordinates.
ChangeGroups groups_of(const std::vector<Changeable>& changeables);

/// Levenberg and Marquardt over the numbers of A and those of B that are apart (changed_sets.h), within the bounds,
/// from `start`, whose b is made equal to a where nothing changed. Pinned numbers of a side stay where they are pinned,
/// and where a group is not apart they hold both. Throws WorkError where the start cannot be simulated, Interrupted.
JointFit fit_jointly(const Side& a, const Side& b, const ChangeGroups& groups, const ChangedSet& changed,
                     JointFit start, const std::atomic<bool>* stop, int iterations = 15);

}  // namespace lacuna
