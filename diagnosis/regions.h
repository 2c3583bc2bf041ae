// The states of one joint at samples of a recording, and the regions of them that a diagnosis speaks of.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "physics/experiment.h"

namespace lacuna {

/// One entry per sample each. Speeds and accelerations are central differences of the measured position over +-5
/// samples; 0 where it is not measured.
struct JointStates {
  std::vector<double> t;               ///< s since the session began
  std::vector<double> q, v, a;         ///< rad or m; per s; per s^2
  std::vector<double> u;               ///< command, V
  std::vector<double> since_reversal;  ///< s since the joint last changed its direction
  std::vector<double> others;          ///< squared speeds of the other joints, each in units of its rms, added up

  void append(const JointStates& more);
};

/// At `samples`, ascending indices into the segment. The position of `joint` must be measured.
JointStates joint_states(const Experiment& experiment, const Segment& segment, std::size_t joint,
                         std::span<const std::size_t> samples);

struct Region {
  std::string words;
  std::function<bool(const JointStates&, std::size_t)> holds;  ///< at that entry
};
/// Of one joint; "while other joints move" is told from the median of `all` its states.
std::vector<Region> regions_of(const Experiment& experiment, std::size_t joint, const JointStates& all);

/// Channel that measures each joint's position; -1: none.
std::vector<int> position_channels(const Experiment& experiment);

}  // namespace lacuna
