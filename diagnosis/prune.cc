#include "diagnosis/prune.h"

#include <cmath>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/decide.h"
#include "diagnosis/without.h"
#include "diagnosis/worth.h"

namespace lacuna {
namespace {

/// Log-likelihood that one finding more must be ahead by where it takes no more numbers.
constexpr double kOneMore = 1.0;

struct Loss {
  double gain = HUGE_VAL;  ///< log-likelihood that the finding is worth, train and validate
  bool needed = true;
  std::optional<Without> rest;  ///< where it can be simulated without it
};

/// What finding k is worth beside the others.
Loss loss_of(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
             const std::vector<Finding>& findings, const FitContext& context) {
  std::vector<Without> rests{without(k, plain, current, findings, context.experiment)};
  if (const auto heir = heir_of(k, findings))
    rests.push_back(handed_over(k, *heir, plain, current, findings, context.experiment));
  Loss least;
  for (Without& rest : rests) {
    if (!refit(rest.model, context)) continue;  // the motion cannot even be simulated
    const Worth worth = worth_over(current, rest.model, context);
    const double gain = worth.gain();
    if (!(gain < least.gain)) continue;
    least.gain = gain;
    least.needed = worth.parameters > 0 ? worth.chance(1) <= kChance && (!worth.heldout || held_out(*worth.heldout))
                                        : gain > kOneMore;
    least.rest = std::move(rest);
  }
  return least;
}

}  // namespace

std::vector<std::string> prune(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                               const FitContext& context) {
  std::vector<std::string> removed;
  while (findings.size() > 1) {
    std::optional<Loss> least;
    std::size_t which = 0;
    for (std::size_t k = 0; k < findings.size(); ++k) {
      Loss loss = loss_of(k, plain, current, findings, context);
      if (loss.needed || (least && loss.gain >= least->gain)) continue;
      least = std::move(loss);
      which = k;
    }
    if (!least) break;
    removed.push_back(findings[which].effect + " at " + findings[which].place);
    current = std::move(least->rest->model);
    refine(current, context);
    findings = std::move(least->rest->findings);
  }
  return removed;
}

}  // namespace lacuna
