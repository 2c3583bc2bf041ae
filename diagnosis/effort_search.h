// The search for what is missing where efforts are predicted: sets of effects compete as wholes.
//
// An effort by inverse dynamics is linear in nearly everything that may be missing (frictions, offsets, mass
// properties), so that one fit tells what every effect at every place would do beside all the others (linearised.h).
// Each round puts in, at every joint, the effect of most evidence there, takes out what is no longer worth its numbers,
// or exchanges one effect for another, and fits the whole set in full before it is looked at again. What remains must
// predict the validate recordings, too. Then each member is weighed against the set without it and with its rivals in
// its place, over blocks of the recordings drawn again.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

struct EffortSearchResult {
  CurrentModel model;  ///< fitted, with everything that is claimed and the efforts' scales
  std::vector<Finding> findings;
  std::vector<std::vector<Candidate>> rounds;
  std::vector<std::string> notes;
};

struct EffortSearchOptions {
  std::uint64_t seed = 1;
  std::function<void(double done)> progress = {};
};

/// From the fitted plain model.
EffortSearchResult search_efforts(const CurrentModel& plain, const FitContext& context,
                                  const EffortSearchOptions& options);

}  // namespace lacuna
