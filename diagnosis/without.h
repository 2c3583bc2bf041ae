// A model of several findings with one of them taken out or exchanged, not fitted yet.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

/// `current` anew from `plain`, at its values, without finding `which` or with `instead` in its place (own coordinates
/// `own`). `plain`: the model before any finding; the effects of `current` are those of `findings`, in order.
CurrentModel rebuilt(const CurrentModel& plain, const CurrentModel& current, const std::vector<Finding>& findings,
                     const Experiment& experiment, std::size_t which, const EffectSpec* instead = nullptr,
                     const std::vector<double>& own = {});

/// The finding at the same place that contains finding k (EffectInfo::contains), as a spring the inertia behind it.
std::optional<std::size_t> heir_of(std::size_t k, const std::vector<Finding>& findings);

struct Without {
  std::vector<Finding> findings;
  CurrentModel model;
};

/// The others as they are.
Without without(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
                const std::vector<Finding>& findings, const Experiment& experiment);

/// The others, finding k's numbers added to those of `heir` of the same name, which are free from then on: a fit that
/// begins where the heir has none of them need not find its way to where it has all.
Without handed_over(std::size_t k, std::size_t heir, const CurrentModel& plain, const CurrentModel& current,
                    const std::vector<Finding>& findings, const Experiment& experiment);

}  // namespace lacuna
