// What a part of a model is worth: the model with it against the model without it, both fitted.
#pragma once

#include <optional>

#include "diagnosis/candidates.h"
#include "diagnosis/evidence.h"

namespace lacuna {

struct Worth {
  Gain train;
  std::optional<HeldoutGain> heldout;  ///< where there are validate recordings; the fit's own errors counted
  int parameters = 0;                  ///< of the part

  double gain() const { return train.log_likelihood + (heldout ? heldout->gain : 0.0); }
  /// Chance of it if the part is not there, times `tries`.
  double chance(int tries) const;
};

/// Residuals of both in the weights of `with`. `without`: fitted with those weights, its Jacobian known.
Worth worth_over(const CurrentModel& with, const CurrentModel& without, const FitContext& context);

}  // namespace lacuna
