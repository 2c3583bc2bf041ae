// Step 5: the found model on recordings that were never used, on the identifying engine and on every other one.
#pragma once

#include "diagnosis/diagnosis.h"
#include "diagnosis/screen.h"

namespace lacuna {

/// Joints whose rms grew by more than `margin` of it, any of their channels, each once.
constexpr double kGrown = 0.02;  ///< less is what a drawn noise does
std::vector<std::string> joints_that_grew(const JointRms& before, const JointRms& after,
                                          const std::vector<std::string>& joints, double margin = kGrown);

/// Fills `engines` (residual before and after on the test recordings, engine by engine, same parameters; what they keep
/// of the gain with the starts' errors taken off), `worse` (from the fits before and after), `worse_besides_starts`,
/// `whiteness` and `traces`.
void verify(Diagnosis& out, const CurrentModel& before, const CurrentModel& after, const FitContext& context,
            bool other_engines);

}  // namespace lacuna
