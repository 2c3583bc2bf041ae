// Second look at every finding among several: in the round that found it the others were still missing, and what it
// then stood for may be theirs. Beside them, each must still be better than its rivals.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Where there are two findings or more: puts a rival in a finding's place if that has more evidence beside the others,
/// which the effect that stood there is a rival of from then on. What else is said of the findings is left to
/// judge_anew(). Returns what was exchanged, in words.
std::vector<std::string> exchange(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                                  const FitContext& context);

}  // namespace lacuna
