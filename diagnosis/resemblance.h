// What a learned curve looks like: which textbook law comes nearest, and what it does.
#pragma once

#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Fills `resembles`, `share`, `height`, `description` and `tells_more` from the curve, its variables and its period.
void describe_curve(LearnedLaw& law);

}  // namespace lacuna
