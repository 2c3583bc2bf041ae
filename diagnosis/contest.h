// A finding among its rivals: each put in its place beside the other findings, re-identified, and weighed.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Log-likelihood that `other` is worth over `standing` on train and validate recordings, less Schwarz's penalty for
/// what it has more of parameters; minus infinity where it diverges.
double evidence_over(const CurrentModel& standing, const CurrentModel& other, const FitContext& context);

/// `current` with finding `which`'s effect exchanged for the rival's, refitted; nothing where it cannot be simulated,
/// and where the rival is a finding already. `plain`, `findings` as in without.h.
std::optional<CurrentModel> exchanged(std::size_t which, const Rival& rival, const CurrentModel& plain,
                                      const CurrentModel& current, const std::vector<Finding>& findings,
                                      const FitContext& context);

/// A rival in a finding's place.
struct Entrant {
  Rival rival;
  CurrentModel model;
  double evidence = 0.0;  ///< over that of the finding as it stands
};

/// The rivals of finding `which` in its place, those that exchanged() can put there and whose numbers end within their
/// ranges, as those of any finding must; most evidence first.
std::vector<Entrant> contest(std::size_t which, const CurrentModel& plain, const CurrentModel& current,
                             const std::vector<Finding>& findings, const FitContext& context);

/// Probability, rivals and class of `finding`, whose evidence is 0, among it and the entrants; the share of what
/// takes no part (Finding::outside) stays what it was.
void settle(Finding& finding, const std::vector<Entrant>& entrants);

}  // namespace lacuna
