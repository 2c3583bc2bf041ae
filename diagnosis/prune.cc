#include "diagnosis/prune.h"

#include <cmath>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/decide.h"
#include "diagnosis/worth.h"

namespace lacuna {
namespace {

struct Loss {
  double gain = HUGE_VAL;  ///< log-likelihood that the finding is worth, train and validate
  bool needed = true;
  CurrentModel rest;
};

/// What finding k is worth beside the others.
Loss loss_of(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
             const std::vector<Finding>& findings, const Experiment& experiment, const SimulatorOptions& options,
             const RunControl& control) {
  Loss out{HUGE_VAL, true, rebuilt(plain, current, findings, experiment, k)};
  CurrentModel& rest = out.rest;
  if (!refit(rest, experiment, options, control)) return out;  // without it the motion cannot even be simulated
  const Worth worth = worth_over(current, rest, experiment, options);
  out.gain = worth.gain();
  out.needed = worth.chance(1) <= kChance && (!worth.heldout || held_out(*worth.heldout));
  return out;
}

}  // namespace

CurrentModel rebuilt(const CurrentModel& plain, const CurrentModel& current, const std::vector<Finding>& findings,
                     const Experiment& experiment, std::size_t which, const EffectSpec* instead,
                     const std::vector<double>& own) {
  auto at = current.fit.point.begin();
  auto take = [&](std::size_t count) {
    const std::vector<double> taken(at, at + static_cast<std::ptrdiff_t>(count));
    at += static_cast<std::ptrdiff_t>(count);
    return taken;
  };
  CurrentModel out{plain.model, plain.space, current.weights, {}};
  out.fit.point = take(plain.space.size());
  for (std::size_t k = 0; k < findings.size(); ++k) {
    const Finding& f = findings[k];
    const EffectSpec spec{f.effect, f.place, f.fixed, f.recordings, f.effect};
    const CurrentModel more = extended(out, experiment, spec, out.fit.point, {});
    const std::vector<double> present = take(more.space.size() - out.space.size());
    if (k != which) out = extended(out, experiment, spec, out.fit.point, present);
    if (k == which && instead != nullptr) out = extended(out, experiment, *instead, out.fit.point, own);
  }
  return out;
}

std::vector<std::string> prune(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                               const Experiment& experiment, const SimulatorOptions& options,
                               const RunControl& control) {
  std::vector<std::string> removed;
  while (findings.size() > 1) {
    std::optional<Loss> least;
    std::size_t which = 0;
    for (std::size_t k = 0; k < findings.size(); ++k) {
      Loss loss = loss_of(k, plain, current, findings, experiment, options, control);
      if (loss.needed || (least && loss.gain >= least->gain)) continue;
      least = std::move(loss);
      which = k;
    }
    if (!least) break;
    removed.push_back(findings[which].effect + " at " + findings[which].place);
    current = std::move(least->rest);
    RunControl quiet = control;
    quiet.progress = nullptr;
    refine(current, experiment, options, quiet);
    findings.erase(findings.begin() + static_cast<std::ptrdiff_t>(which));
  }
  return removed;
}

}  // namespace lacuna
