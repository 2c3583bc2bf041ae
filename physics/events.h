// What happened once in a recording and is no part of the machine: pushes, commands lost, slips of a transducer.
//
// An event stands in the segment that it is simulated in: an effort on a joint besides all else, another command than
// the recorded one, an offset of what a position's transducer reads. What was measured stays as it is.
#pragma once

#include <span>

#include "physics/experiment.h"

namespace lacuna {

/// EventSpec on the clock of a segment's commands: begin and end in s, joint by index; value in its unit.
struct Event {
  EventSpec::Kind kind = EventSpec::Kind::effort;
  int joint = 0;
  double begin = 0.0, end = 0.0;
  double value = 0.0;
  double rise = 0.0;  ///< s, in which an effort comes and goes, at most half of the way from begin to end
};

/// What a unit event is on each interval between samples (an effort's mean) or at each sample (a slip).
std::vector<double> mean_of_intervals(const Segment& segment, const Event& event);
std::vector<double> value_at_samples(const Segment& segment, const Event& event);

/// Puts an event into a segment beside those that it has. An effort is what it is on the mean of each interval; a
/// command and a reading at the samples from `begin` to before `end`, a reading that lasts to the end at the last one,
/// too. Where it does not touch the segment nothing is changed.
void add_event(Segment& segment, const Event& event);

/// Puts the scenario's events into the experiment's segments of their recordings. Throws InputError where one is not in
/// its recording (recordings that are not in the experiment have none), has no command or position to act on, or the
/// motion is measured and not simulated.
void add_events(const Scenario& scenario, Experiment& experiment);

/// The other way: an event of a segment as a scenario says it.
EventSpec spec_of(const Event& event, const Segment& segment, const Experiment& experiment);

}  // namespace lacuna
