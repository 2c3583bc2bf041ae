// What surrounds a fitted set of effects where efforts are predicted: every effect put in, taken out or given one
// number more, each simulated once, and the sensitivities of all numbers. From this alone sets are weighed
// (linearised.h).
#pragma once

#include <vector>

#include "diagnosis/hypothesis.h"

namespace lacuna {

/// Everything simulated and differentiated about a set, in its weights; whitened with its own colour.
struct Surroundings {
  std::vector<ResidualBlock> train_blocks, validate_blocks;
  Eigen::VectorXd train, validate;
  std::vector<LinearColumn> plain;
  std::vector<Part> parts;
  double correlation = 1.0;  ///< samples
};

/// `with_rivals`: with the effects and numbers that the set does not have.
Surroundings surroundings_of(const Hypotheses& sets, const Hypothesis& standing, bool with_rivals);

/// Where an effect of the catalogue may stand that the set does not have there.
std::vector<EffectSpec> offered_beside(const Hypotheses& sets, const Hypothesis& standing, const EffectInfo& effect);

/// `for_bagging`: block by block of the recordings.
Linearised linearised(Surroundings surroundings, bool for_bagging);

}  // namespace lacuna
