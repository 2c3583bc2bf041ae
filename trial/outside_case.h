// Physics outside the catalogue in a case: the numbers of its form, drawn so that nobody chose them, and what the label
// says of it.
#pragma once

#include <string>
#include <vector>

#include "ga/random.h"
#include "physics/experiment.h"
#include "physics/outside.h"
#include "scenarios/robot.h"

namespace lacuna {

/// Where a machine goes in the train recordings, by joint.
struct Travel {
  struct Range {
    double lowest = 0.0, highest = 0.0;
    double width() const { return highest - lowest; }
    double at(double share) const { return lowest + share * width(); }
  };
  std::vector<Range> position;    ///< rad (m)
  std::vector<Range> command;     ///< the command's unit
  std::vector<double> speed_rms;  ///< rad/s (m/s)
};

/// The form of a law that lies within the travel. Throws InputError naming `where` for a joint that cannot have it.
OutsidePhysics::Form drawn_form(const OutsidePhysics& physics, const Travel& travel, const Robot& robot,
                                RandomStream stream, const std::string& where);

/// `signal` of the channel as a transducer gives it that repeats its last sample where one of `all` says so.
void repeat_samples(const std::vector<OutsidePhysics>& all, const Channel& channel, const Segment& segment,
                    std::vector<double>& signal);

/// The curve over the travel, or what happened when; `files` are the recordings' names by index.
LawRecord law_record(const OutsidePhysics& physics, const Travel& travel, const Experiment& experiment,
                     const std::vector<std::string>& files);

}  // namespace lacuna
