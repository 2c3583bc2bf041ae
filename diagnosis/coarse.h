// The neighbourhood of the present model at a coarser step than its own.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "diagnosis/candidates.h"

namespace lacuna {

/// A step at which neighbours of the present model are compared with it: many simulations that are only to be ranked.
/// What that step does to the present model itself is known, and taken off all of them.
struct CoarseLook {
  FitContext context;          ///< with that step
  Eigen::VectorXd correction;  ///< whitened; to be added to the residuals of `train` at that step

  /// Corrected residuals of full parameter vectors.
  std::vector<Eigen::VectorXd> residuals_of(Problem& problem, std::span<const std::vector<double>> values,
                                            std::span<const int> train) const;
};

/// The longest of two and four times the model's step at which the correction is no more than a tenth of the energy
/// that is to be explained; the model's own step where even the first is too long.
CoarseLook coarse_look(const CurrentModel& current, const FitContext& context);

/// Whether another step changes more than a trace of what the model leaves on the train recordings. Beside a rest far
/// above the noise a step as fine as the noise asks for changes no comparison.
bool step_matters(const CurrentModel& current, const FitContext& context, double step);

/// The longest step, doubled from the present one, that does not matter; s.
double coarse_enough(const CurrentModel& current, const FitContext& context);

/// As many windows of the recordings (thinned.h), and steps as long, as it takes to compare a model with others.
class Enough {
 public:
  Enough(const CurrentModel& current, const FitContext& context);
  Enough(const Enough&) = delete;  // the context is of this experiment
  Enough& operator=(const Enough&) = delete;

  const FitContext& context() const { return context_; }
  bool is_all() const { return all_; }  ///< windows and steps are those of the context that it was made from

 private:
  Experiment experiment_;
  FitContext context_;
  bool all_ = true;
};

}  // namespace lacuna
