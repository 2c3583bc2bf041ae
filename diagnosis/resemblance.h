// What a learned curve looks like: which textbook law comes nearest, and what it does.
#pragma once

#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Fills `resembles`, `share`, `height` and `description` from the curve and its period.
void describe_curve(LearnedLaw& law);

}  // namespace lacuna
