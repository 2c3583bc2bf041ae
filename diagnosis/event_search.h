// What happened once in one recording, to first order: rectangles in time of an effort at a joint or of a reading.
//
// Through the plant linearised about the present motion (linear_look.h) every rectangle's change of the residual is
// known. The pair of edges that takes most away is put in, then the next of what is left, all sizes anew by least
// squares (orthogonal matching pursuit: Y. C. Pati, R. Rezaiifar, P. S. Krishnaprasad, Asilomar 1993); those that the
// rest does not need are taken out again.
#pragma once

#include <vector>

#include "diagnosis/candidates.h"
#include "physics/events.h"

namespace lacuna {

struct FoundEvent {
  int segment = 0;
  Event event;
  double evidence = 0.0;  ///< log evidence over the same without it, corrected for all edges tried
};

/// In segments of one role, beside the events that they have; by segment, in the order of time. Parameters that were
/// fitted to these segments (train) have taken up part of what happened: `fitted` lets them give it back. None where
/// events do not take away most of what a segment leaves beyond the noise.
std::vector<FoundEvent> search_events(const CurrentModel& model, const FitContext& context,
                                      const std::vector<int>& segments, bool fitted);

/// Events of these segments, `with` them in, moved and sized anew about the motion as it is with them.
void sharpen(const CurrentModel& model, const FitContext& with, const std::vector<int>& segments, bool fitted,
             std::vector<FoundEvent>& events);

}  // namespace lacuna
