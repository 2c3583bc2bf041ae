// Screening: the current model re-identified with every effect at every place, one at a time.
//
// Each candidate starts at the present fit and one of its effect's starting sizes, and takes damped Gauss-Newton steps
// over all parameters at once, the plain ones and its own. The sensitivities are those of the present fit plus the
// effect's own, kept up to date by Broyden's rank-one update, so a step costs one simulation a candidate and all
// candidates of an effect share one population call. Source of the update: C. G. Broyden, Math. Comp. 19 (1965).
// All that is simulated here only ranks, and is simulated at a coarser step where that is good enough (coarse.h).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"

namespace lacuna {

/// An effect at a place, with all parameters re-identified.
struct ScreenedEffect {
  EffectSpec spec;              ///< effect, place, recordings; parameters named in it are fixed
  std::vector<double> point;    ///< search point of the current model, re-identified
  std::vector<double> own;      ///< the effect's own coordinates
  double sum_of_squares = 0.0;  ///< on the train segments
  Eigen::VectorXd residual;     ///< on the train segments
  int parameters = 0;
  double promise = 0.0;           ///< sum of squares that the first, linear look at its best start expected
  std::vector<double> first_own;  ///< own coordinates of that start
};

struct ScreenOptions {
  std::function<bool(const std::string& place)> where;  ///< whether effects are tried there: a joint, "arm"
  std::function<void(double done)> progress = {};
  std::function<bool(const EffectSpec&)> skipped = {};  ///< what is left out besides
};

/// Every effect of the catalogue at every place where it can act and does not stand yet; the best of its starts.
std::vector<ScreenedEffect> screen_effects(const CurrentModel& current, const FitContext& context,
                                           const ScreenOptions& options);

}  // namespace lacuna
