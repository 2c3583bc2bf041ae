// Where a ripple over a joint's angle begins in a search: what the efforts that are left repeat with.
//
// An effort a sin(n q) + b cos(n q) is told from one with another n as soon as n differs by about 1 / range of q: no
// list of values hits it. So all n that the range and the filter can show are tried against the rest, two sums each
// (least-squares spectrum: N. R. Lomb, Astrophys. Space Sci. 39, 1976, over the angle in the place of time).
#pragma once

#include <vector>

#include "diagnosis/candidates.h"

namespace lacuna {

/// Own coordinates (a, b, n) of ripples at a joint, of most energy in what `current`, fitted, leaves of its measured
/// effort; the strongest first. None where its effort is not measured or it stands still.
std::vector<std::vector<double>> ripple_starts(const CurrentModel& current, const FitContext& context, int joint);

}  // namespace lacuna
