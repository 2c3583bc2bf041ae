// What is another from recording to recording and the same within each: an offset or an edge of a valve that moves, a
// friction that follows the temperature.
//
// The fitted model has one number for all recordings. Beside it each recording has one of its own, d_r off it, normal
// about 0 with a standard deviation s that the evidence chooses. Near the fit the whitened residual is linear in them,
// so that nothing is simulated but the sensitivities (random effects: C. E. McCulloch, S. R. Searle, Generalized,
// Linear, and Mixed Models, 2001, ch. 6). At every joint the number of most evidence goes first, the next one beside
// it. A law that the model lacks can look like it where recordings are commanded differently: what one half of a
// recording says of its number must predict the other half better.
#pragma once

#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// Of the numbers that the model has at those of `joints` (an offset of every valve among them), where the train and
/// validate recordings speak for it; in the order of the joints, most evidence first. None where there is one
/// recording.
std::vector<NumberByRecording> numbers_by_recording(const CurrentModel& current, const FitContext& context,
                                                    const std::vector<std::string>& joints);

}  // namespace lacuna
