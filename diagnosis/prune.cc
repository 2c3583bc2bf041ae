#include "diagnosis/prune.h"

#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/baseline.h"
#include "diagnosis/decide.h"
#include "diagnosis/worth.h"

namespace lacuna {
namespace {

/// Log-likelihood that one finding more must be ahead by where it takes no more numbers.
constexpr double kOneMore = 1.0;

struct Rest {
  std::vector<Finding> findings;
  CurrentModel model;
};

struct Loss {
  double gain = HUGE_VAL;  ///< log-likelihood that the finding is worth, train and validate
  bool needed = true;
  std::optional<Rest> rest;  ///< where it can be simulated without it
};

std::map<std::string, double> own_values(const CurrentModel& current, const Finding& finding) {
  const std::vector<double> values = current.space.expand(current.fit.point);
  const Component& component =
      current.model.effects()[static_cast<std::size_t>(current.model.find_effect_at(finding.effect, finding.place))];
  std::map<std::string, double> out;
  for (int k = component.first; k < component.first + component.count; ++k)
    out[current.model.parameters()[static_cast<std::size_t>(k)].info->name] = values[static_cast<std::size_t>(k)];
  return out;
}

Rest without(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
             const std::vector<Finding>& findings, const Experiment& experiment) {
  Rest out{findings, rebuilt(plain, current, findings, experiment, k)};
  out.findings.erase(out.findings.begin() + static_cast<std::ptrdiff_t>(k));
  return out;
}

/// What `given` had goes to the heir's numbers of the same name, which are free from now on.
Rest handed_over(const Rest& rest, std::size_t heir, const std::map<std::string, double>& given,
                 const CurrentModel& plain, const Experiment& experiment) {
  Rest out = rest;
  Finding& finding = out.findings[heir];
  for (const auto& [name, value] : given) finding.fixed.erase(name);
  const EffectSpec spec{finding.effect, finding.place, finding.fixed, finding.recordings, finding.effect};
  const std::map<std::string, double> present = own_values(rest.model, finding);
  const PlantModel model = plain.model.with_effects({spec});
  std::vector<double> own;
  for (const Axis& axis : effect_axes(model, experiment, model.effects().back(), spec)) {
    const std::string name = model.parameters()[static_cast<std::size_t>(axis.parameter)].info->name;
    const auto more = given.find(name);
    own.push_back(to_search(axis.coordinate, present.at(name) + (more == given.end() ? 0.0 : more->second)));
  }
  out.model = rebuilt(plain, rest.model, rest.findings, experiment, heir, &spec, own);
  return out;
}

/// The others without finding k, not fitted: as they are, and with its numbers handed to each that contains it. A fit
/// that begins where they have none of them need not find its way to where they have all.
std::vector<Rest> rests_of(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
                           const std::vector<Finding>& findings, const Experiment& experiment) {
  std::vector<Rest> out{without(k, plain, current, findings, experiment)};
  const Finding& taken = findings[k];
  for (std::size_t heir = 0; heir < out.front().findings.size(); ++heir) {
    const Finding& other = out.front().findings[heir];
    const char* contains = effect_table()[static_cast<std::size_t>(find_effect(other.effect))].contains;
    if (contains == nullptr || taken.effect != contains || other.place != taken.place) continue;
    out.push_back(handed_over(out.front(), heir, own_values(current, taken), plain, experiment));
  }
  return out;
}

/// What finding k is worth beside the others.
Loss loss_of(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
             const std::vector<Finding>& findings, const Experiment& experiment, const SimulatorOptions& options,
             const RunControl& control) {
  Loss least;
  for (Rest& rest : rests_of(k, plain, current, findings, experiment)) {
    if (!refit(rest.model, experiment, options, control)) continue;  // the motion cannot even be simulated
    const Worth worth = worth_over(current, rest.model, experiment, options);
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
    current = std::move(least->rest->model);
    RunControl quiet = control;
    quiet.progress = nullptr;
    refine(current, experiment, options, quiet);
    findings = std::move(least->rest->findings);
  }
  return removed;
}

}  // namespace lacuna
