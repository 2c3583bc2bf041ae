#include "physics/reach.h"

#include <algorithm>

#include "physics/actuators/table.h"
#include "physics/effects/table.h"

namespace lacuna {
namespace {

/// Whether it changes bodies, what they stand on, what a joint's position is read as, or what another joint gets.
bool reaches_others(const Hooks<double>& hooks) {
  return hooks.inertials != nullptr || hooks.gravity != nullptr || hooks.base != nullptr || hooks.share != nullptr ||
         hooks.sense != nullptr || hooks.unsense != nullptr;
}

}  // namespace

std::vector<bool> stays_at_its_joint(const PlantModel& model, const Prediction& prediction) {
  std::vector<bool> out(model.parameters().size(), false);
  if (!std::holds_alternative<InverseDynamics>(prediction)) return out;
  const auto& effects = Effects::hooks<double>();
  const bool share =
      std::ranges::any_of(model.effects(), [&](const Component& c) { return effects[c.type].share != nullptr; });
  if (share) return out;  // what one asks for changes what the others get
  const auto mark = [&](const Component& c, const Hooks<double>& hooks) {
    if (c.joint < 0 || reaches_others(hooks)) return;
    std::fill_n(out.begin() + c.first, c.count, true);
  };
  for (const Component& c : model.actuators())
    if (c.type >= 0) mark(c, Actuators::hooks<double>()[c.type]);
  for (const Component& c : model.effects()) mark(c, effects[c.type]);
  return out;
}

}  // namespace lacuna
