#include "diagnosis/without.h"

#include <map>

namespace lacuna {
namespace {

std::map<std::string, double> own_values(const CurrentModel& current, const Finding& finding) {
  const std::vector<double> values = current.space.expand(current.fit.point);
  const Component& component = current.model.effects()[current.model.find_effect_at(finding.effect, finding.place)];
  std::map<std::string, double> out;
  for (int k = component.first; k < component.first + component.count; ++k)
    out[current.model.parameters()[k].info->name] = values[k];
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

std::optional<std::size_t> heir_of(std::size_t k, const std::vector<Finding>& findings) {
  for (std::size_t heir = 0; heir < findings.size(); ++heir) {
    const char* contains = effect_table()[find_effect(findings[heir].effect)].contains;
    if (contains != nullptr && findings[k].effect == contains && findings[heir].place == findings[k].place) return heir;
  }
  return std::nullopt;
}

Without without(std::size_t k, const CurrentModel& plain, const CurrentModel& current,
                const std::vector<Finding>& findings, const Experiment& experiment) {
  Without out{findings, rebuilt(plain, current, findings, experiment, k)};
  out.findings.erase(out.findings.begin() + static_cast<std::ptrdiff_t>(k));
  return out;
}

Without handed_over(std::size_t k, std::size_t heir, const CurrentModel& plain, const CurrentModel& current,
                    const std::vector<Finding>& findings, const Experiment& experiment) {
  Without out = without(k, plain, current, findings, experiment);
  if (heir > k) --heir;
  const std::vector<Finding> before = out.findings;
  const std::map<std::string, double> given = own_values(current, findings[k]);
  Finding& finding = out.findings[heir];
  for (const auto& [name, value] : given) finding.fixed.erase(name);
  const EffectSpec spec{finding.effect, finding.place, finding.fixed, finding.recordings, finding.effect};
  const std::map<std::string, double> present = own_values(out.model, finding);
  const PlantModel model = plain.model.with_effects({spec});
  std::vector<double> own;
  for (const Axis& axis : effect_axes(model, experiment, model.effects().back(), spec)) {
    const std::string name = model.parameters()[axis.parameter].info->name;
    const auto more = given.find(name);
    own.push_back(to_search(axis.coordinate, present.at(name) + (more == given.end() ? 0.0 : more->second)));
  }
  out.model = rebuilt(plain, out.model, before, experiment, heir, &spec, own);
  return out;
}

}  // namespace lacuna
