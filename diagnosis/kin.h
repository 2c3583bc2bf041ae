// Effects that are special cases of one another: a gap that closes is a spring, a spring that stiffens an inertia. What
// the search of one has found is where the search of the other begins; without that a richer effect can stop at a worse
// fit than the simpler one it contains, and the two cannot be compared.
#pragma once

#include <vector>

#include "diagnosis/screen.h"

namespace lacuna {

/// Whether all numbers of one are found among those of the other, by name and unit; optional ones not counted.
bool are_kin(const EffectInfo& one, const EffectInfo& other);

/// Whether what both contain could be told of either, at one place: one is a special case of the other, or both are of
/// a third effect. Not those that act beside each other (EffectInfo::in_parallel).
bool overlap(const EffectInfo& one, const EffectInfo& other);

/// `kin` at the place of `source`, whose re-identified model is `model`: numbers that both have are those found, and of
/// a grid over the others the point that leaves least on the train recordings. With the optional ones at neutral; where
/// the source has some of them free, with those free as well. What cannot be simulated is left out.
std::vector<ScreenedEffect> kin_starts(const EffectInfo& kin, const ScreenedEffect& source, const CurrentModel& model,
                                       const CurrentModel& current, const FitContext& context);

}  // namespace lacuna
