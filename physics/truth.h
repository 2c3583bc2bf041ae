// A plant's motion by another integrator than the rollout's: what concealed recordings are made with.
//
// Identification runs Kutta's fourth-order steps of fixed length (rollout.h). Here it is the Dormand-Prince pair of
// orders 5 and 4 with step control (Boost.odeint), on any engine's accelerations, and dry friction is an event that is
// bisected. The equations of actuators and effects are the catalogue's own, written once; what differs is everything
// that carries them through time. Physics that the catalogue does not have (outside.h) can be added here, and only
// here. The same code in extended precision under a method of eighth order is the referee of `lacuna compare`.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "physics/executor.h"
#include "physics/experiment.h"
#include "physics/outside.h"
#include "physics/plant_model.h"

namespace lacuna {

/// A parameter that is not constant: value (1 + share sin(2 pi (x - centre) / width)), x the joint's position or, where
/// the effect stands on the command's way, its command.
struct UnevenParameter {
  int parameter = 0, joint = 0;  ///< of the plant
  bool over_command = false;
  double share = 0.0;                ///< below 1
  double centre = 0.0, width = 1.0;  ///< rad (m), or the command's unit
};

/// What a simulation took.
struct TruthEffort {
  long evaluations = 0;  ///< of the forward dynamics
  double seconds = 0.0;  ///< CPU time, building the engine left out
};

struct TruthOptions {
  std::string engine = "simbody";
  double tolerance = 1e-8;    ///< of a step, absolute and relative; rad and rad/s (m, m/s)
  double memory_step = 5e-4;  ///< s: memories are carried from step to step, unseen by the error estimate
  bool settle = true;         ///< start at rest where the plant rests; else at the segment's own start and speed
  /// Featherstone's equations in `long double` under Fehlberg's pair of orders 8 and 7 instead of `engine`: a
  /// reference. The robot's and the plant's numbers stay the doubles that they are.
  bool extended_precision = false;
  std::vector<OutsidePhysics> outside;       ///< but for repeated samples, which recordings have and motions do not
  std::vector<UnevenParameter> uneven = {};  ///< as Plant::vary() takes them
  TruthEffort* effort = nullptr;             ///< filled where not null
  const StopFlag* stop = nullptr;
};

/// [channel][sample] over the segment, noise-free: positions as their transducers give them, speeds, efforts. With
/// `settle` it starts at rest where the plant rests under the first commands, found by Newton's method from the
/// segment's own start; without, and where there is no such place, at the segment's own start and speed. `values` are
/// those in force in the segment's recording. Throws WorkError where the engine is not available or the motion
/// diverges, Interrupted.
std::vector<std::vector<double>> simulate_truth(const PlantModel& model, const Segment& segment,
                                                const std::vector<Channel>& channels, std::span<const double> values,
                                                const TruthOptions& options);

}  // namespace lacuna
