// What is held for likely of a number before any data: from the catalogue's typical sizes.
#pragma once

#include "diagnosis/candidates.h"
#include "ga/identify.h"

namespace lacuna {

/// Whether an effect vanishes with this number and goes with it in proportion; else it shapes the effect.
bool is_strength(const ParameterInfo& p);

/// Gives every axis that has none a Gaussian prior: an effect's strengths about neutral, its shapes about where they
/// stand, each with its typical size; the plain model's numbers about their start values, with half of their range.
void set_priors(const PlantModel& model, const Experiment& experiment, SearchSpace& space,
                std::span<const double> point);

/// Whether some mass is known that measured efforts can be scaled by: every link's, all of them together, or a load's.
bool knows_a_mass(const PlantModel& model, const SearchSpace& space);

/// Where efforts are measured and no mass is known, all masses are in the unit of the drives' gains, and these are
/// known to a tenth, by one calibration for all: widens the masses' intervals by that.
void carry_scale_error(const PlantModel& model, const SearchSpace& space, const Experiment& experiment,
                       std::vector<Estimate>& estimates);

}  // namespace lacuna
