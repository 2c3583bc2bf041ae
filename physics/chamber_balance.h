// What measured pressures and a measured motion say of a hydraulic joint, link by link of its chain.
//
// With both pressures measured no simulation is needed: the valve's equation says what flow it lets through at its
// command against those pressures, the chambers' say what flow their pressures and the piston's motion took, and the
// piston's force stands beside the effort that the motion needs. Where two of these differ, the link between them is
// wrong, whatever the others are.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/experiment.h"
#include "physics/plant_model.h"

namespace lacuna {

/// Of one joint, at the samples of the segment's motion; empty where no pressures drive it.
struct ChamberBalance {
  /// By how much what the model's valve lets into A (out of B), less its leaks, is more than what the chamber took, as
  /// the joint's speed: rad/s (m/s). NaN where the cylinder has no lever arm.
  std::array<std::vector<double>, 2> flow;
  /// The same of what the chamber took beyond the piston's motion: the compression of its oil, rad/s (m/s).
  std::array<std::vector<double>, 2> compression;
  std::vector<double> effort;  ///< that the motion of the links takes, N m (N)
  std::vector<double> excess;  ///< what drives the joint, its pressures first, beyond what its motion needs, N m (N)
};

/// Along `segment`, of inverse dynamics, whose `pressures` are measured and whose commands are as given.
/// [joint]. `engine`: available. Nothing is filtered.
std::vector<ChamberBalance> chamber_balances(const PlantModel& model, const std::string& engine,
                                             const std::vector<double>& values, const Segment& segment);

}  // namespace lacuna
