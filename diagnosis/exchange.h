// Second look at every finding among several: in the round that found it the others were still missing, and what it
// then stood for may be theirs. Beside them, each must still be better than its rivals.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Log-likelihood that `other` is worth over `standing` on train and validate recordings, less Schwarz's penalty for
/// what it has more of parameters; minus infinity where it diverges.
double evidence_over(const CurrentModel& standing, const CurrentModel& other, const Experiment& experiment,
                     const SimulatorOptions& options);

/// `current` with finding `which`'s effect exchanged for the rival's, refitted; nothing where it cannot be simulated.
/// `plain`, `findings` as in without.h.
std::optional<CurrentModel> exchanged(std::size_t which, const Rival& rival, const CurrentModel& plain,
                                      const CurrentModel& current, const std::vector<Finding>& findings,
                                      const Experiment& experiment, const SimulatorOptions& options,
                                      const RunControl& control);

/// Where there are two findings or more: puts a rival in a finding's place if that has more evidence beside the others,
/// and makes each finding's probability, rivals and class those of this look. A finding that took another's place is
/// judged anew: gain, chance corrected for `tries` candidates, stability against none, times and regions. Returns what
/// was exchanged, in words.
std::vector<std::string> exchange(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                                  const Experiment& experiment, const SimulatorOptions& options,
                                  const RunControl& control, int tries, std::uint64_t seed);

}  // namespace lacuna
