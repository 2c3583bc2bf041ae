// What is held for likely of a number before any data: from the catalogue's typical sizes.
#pragma once

#include "diagnosis/candidates.h"

namespace lacuna {

/// Whether an effect vanishes with this number and goes with it in proportion; else it shapes the effect.
bool is_strength(const ParameterInfo& p);

/// Gives every axis that has none a Gaussian prior: an effect's strengths about neutral, its shapes about where they
/// stand, each with its typical size; the plain model's numbers about their start values, with half of their range.
void set_priors(const PlantModel& model, const Experiment& experiment, SearchSpace& space,
                std::span<const double> point);

}  // namespace lacuna
