// Effects that act in some recordings only: in which.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/coarse.h"

namespace lacuna {

/// Train recordings in which the effect seems to be on: its size is estimated recording by recording, all parameters
/// free, to first order; on are those above half of the largest, measured from the smallest (the plain parameters
/// may have taken up what is common to all). Empty: in all, or in none that could be told.
std::vector<std::string> likely_recordings(const CurrentModel& current, const CoarseLook& coarse,
                                           const EffectSpec& spec);

/// Files among the recordings of `roles` in which the last effect of `with` is on: those that the model predicts better
/// with it than without. A prediction in time is judged by its first second, before other errors have grown; efforts by
/// all of the recording.
std::vector<std::string> recordings_with_effect(const CurrentModel& with, const FitContext& context,
                                                const std::vector<Role>& roles);

}  // namespace lacuna
