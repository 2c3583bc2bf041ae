// The true machine behind the bundled recordings.
//
// Made with nothing that identification on the default engine uses: Simbody's accelerations, a Dormand-Prince method
// with step control, the laws of actuators and friction written out anew. An error in those of physics/ cannot hide.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "scenarios/recording.h"
#include "scenarios/scenario.h"

namespace lacuna::generate {

struct Course {
  std::vector<std::vector<double>> position;                ///< [joint][sample], rad (m)
  std::vector<std::vector<double>> pressure_a, pressure_b;  ///< [joint][sample], Pa; 0 at joints without chambers
};

/// What all joints do at the instants of `commands`, which are held in between. Starts at rest: where the springs carry
/// the weight under zero command, or, where every joint that moves is hydraulic, in the posture of `motion.position`
/// with the pressures that a closed valve has come to. Throws InputError for actuators, effects or a posture that it
/// does not know, WorkError where no rest is found or a hydraulic joint leaves its travel.
Course true_course(const Scenario& truth, const Recording& commands);

}  // namespace lacuna::generate
