// Pushes, lost commands, slips of a transducer: found in each recording on its own, confirmed in full simulation.
//
// To first order they are rectangles in time (event_search.h). Put into the simulation they are sized and moved anew
// about the motion as it is with them. An effort at a joint that is driven is held against two simpler causes over the
// same time: the command was lost (zero), or the last one before it stayed. They are events of a recording, so nothing
// of the machine's parameters stands for them: the model is fitted again with them in.
#pragma once

#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

struct EventsFound {
  CurrentModel model;     ///< fitted beside the events
  Experiment experiment;  ///< with those of the train and validate recordings in
  std::vector<LearnedEvent> events;
};

/// What happened in the recordings under the present model. Test recordings are looked at last, with everything else
/// settled; what happened there is said and not put in. Nothing where recordings are not simulated from end to end: a
/// window is too short to tell an event from the start that was read off it.
EventsFound find_events(const CurrentModel& current, const FitContext& context);

}  // namespace lacuna
