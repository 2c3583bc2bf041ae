// What is another from recording to recording and the same within each: an offset of a valve whose null moves.
//
// Beside the fitted model, in which an offset is one number for all recordings, each recording has an offset of its
// own, d_r, normal about 0 with a standard deviation s that the evidence chooses. Near the fit the whitened residual is
// linear in them, so that nothing is simulated but the sensitivities (a random effect: C. E. McCulloch, S. R. Searle,
// Generalized, Linear, and Mixed Models, 2001, ch. 6). A law that the model lacks can look like it where recordings are
// commanded differently: what one half of a recording says of its offset must predict the other half better.
#pragma once

#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// At those of `joints` that have a command, where the train and validate recordings speak for it; nothing where
/// efforts are predicted, in which a valve has no part, and where there is one recording.
std::vector<OffsetsByRecording> offsets_by_recording(const CurrentModel& current, const FitContext& context,
                                                     const std::vector<std::string>& joints);

}  // namespace lacuna
