// Backward step: of several effects found one after the other, each must still be needed beside those found later.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Takes out of `current`, one at a time and the least needed first, every finding without which the rest of the model,
/// re-identified, is no worse: its gain is within chance on the train recordings or within two standard errors on the
/// validate ones. What another finding there contains of it (EffectInfo::contains) is handed to that one, whose numbers
/// of the same name are free from then on. `plain`: the model before any finding; the effects of `current` are those of
/// `findings`, in order.
/// Returns what was taken out, "effect at place".
std::vector<std::string> prune(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                               const FitContext& context);

}  // namespace lacuna
