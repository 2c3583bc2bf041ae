// An effect whose law is a special case of one that stands, in its place.
#pragma once

#include <optional>

#include "diagnosis/hypothesis.h"

namespace lacuna {

/// The set with effect `simpler`, all of whose numbers `spec` has, in the place of `spec`, fitted; nothing where it is
/// no special case and where it cannot act there.
std::optional<Hypothesis> in_place_of(const Hypotheses& sets, const Hypothesis& standing, const EffectSpec& spec,
                                      const EffectInfo& simpler);

}  // namespace lacuna
