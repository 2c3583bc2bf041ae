// Effects that act in some recordings only: in which.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnosis/coarse.h"

namespace lacuna {

/// Train recordings in which the effect seems to be on: its size is estimated recording by recording, all parameters
/// free, to first order; on are those above half of the largest, measured from the smallest (the plain parameters
/// may have taken up what is common to all). Empty: in all, or in none that could be told.
std::vector<std::string> likely_recordings(const CurrentModel& current, const Experiment& experiment,
                                           const CoarseLook& coarse, const EffectSpec& spec);

/// Files among the recordings of `roles` in which the effect at `component` is on: those whose first second the model
/// predicts better with it than without. `values` include the effect.
std::vector<std::string> recordings_with_effect(const PlantModel& model, const Component& component,
                                                std::span<const double> values, const Experiment& experiment,
                                                const SimulatorOptions& options, const std::vector<double>& weights,
                                                const std::vector<Role>& roles);

}  // namespace lacuna
