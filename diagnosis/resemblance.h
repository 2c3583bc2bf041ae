// What a learned curve looks like: which textbook law comes nearest, and what it does.
#pragma once

#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Fills `resembles`, `share`, `period`, `height` and `description` from the curve.
void describe_curve(LearnedLaw& law);

}  // namespace lacuna
