#include "diagnosis/simpler_name.h"

#include "diagnosis/baseline.h"
#include "diagnosis/kin.h"
#include "diagnosis/surroundings.h"

namespace lacuna {
namespace {

/// Where the numbers of `simpler` start: where those of the same name stand.
std::vector<double> start_of(const Hypotheses& sets, const CurrentModel& standing, const EffectSpec& old,
                             const EffectSpec& simpler) {
  const std::vector<double> values = standing.space.expand(standing.fit.point);
  const std::size_t at = standing.model.find_effect_at(old.effect, old.place);
  const Component& stands = standing.model.effects()[at];
  const PlantModel model = sets.plain().model.with_effects({simpler});
  std::vector<double> out;
  for (const Axis& axis : effect_axes(model, sets.context().experiment, model.effects().back(), simpler)) {
    const std::string& key = model.parameters()[axis.parameter].key;
    for (int k = stands.first; k < stands.first + stands.count; ++k)
      if (standing.model.parameters()[k].key == key) out.push_back(to_search(axis.coordinate, values[k]));
  }
  return out;
}

}  // namespace

std::optional<Hypothesis> in_place_of(const Hypotheses& sets, const Hypothesis& standing, const EffectSpec& spec,
                                      const EffectInfo& simpler) {
  const EffectInfo& old = effect_info(spec.effect);
  if (!are_kin(simpler, old) || simpler.parameters.size() >= old.parameters.size()) return std::nullopt;
  for (EffectSpec& one : offered_beside(sets, standing, simpler)) {
    if (one.place != spec.place) continue;
    SetChange change;
    change.out.push_back(place_of(spec));
    change.own.push_back(start_of(sets, standing.model, spec, one));
    change.in.push_back(std::move(one));
    return sets.changed(standing, change, kRefitIterations);
  }
  return std::nullopt;
}

}  // namespace lacuna
