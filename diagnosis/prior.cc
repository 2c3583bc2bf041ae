#include "diagnosis/prior.h"

#include <algorithm>
#include <cmath>

#include "physics/effects/table.h"

namespace lacuna {
namespace {

constexpr double kRatioPrior = 0.3;  ///< of shares and logarithms of masses
constexpr double kNormal95 = 1.96;   ///< standard errors
constexpr double kScaleError = 0.1;  ///< of a drive's gain: such figures are known to about a tenth
constexpr double kMostScale = 3.0;   ///< standard deviations: beyond it something else is wrong
constexpr double kMassPrior = 0.3;   ///< of the arm's mass: a load
constexpr double kDecade = 2.3;      ///< of what is known by its order of magnitude only
constexpr double kOfRange = 0.5;     ///< of a plain number's range

/// Of an effect's own number, in its search coordinate.
double deviation(const Parameter& p, const PlantModel& model, const Experiment& experiment) {
  const ParameterInfo& info = *p.info;
  const double size = typical_size(info.scale, model, experiment, p.joint, model.values());
  if (info.coordinate == Coordinate::logarithm) return kDecade;
  if (info.coordinate == Coordinate::inverse) return 1.0 / size;
  switch (info.scale) {
    case Scale::ratio: return is_strength(info) ? kRatioPrior : std::max(std::fabs(p.value), 1e-9);
    case Scale::mass: return kMassPrior * size;
    case Scale::inertia: return std::max(size, driven_inertia(model, experiment, p.joint));
    default: return is_strength(info) ? size : std::max(std::fabs(p.value), 0.1 * size);
  }
}

}  // namespace

bool is_strength(const ParameterInfo& p) {
  return p.neutral == 0.0 && p.coordinate == Coordinate::linear && !p.optional && p.scale != Scale::reach;
}

void set_priors(const PlantModel& model, const Experiment& experiment, SearchSpace& space,
                std::span<const double> point) {
  std::vector<Axis> axes = space.axes();
  for (std::size_t a = 0; a < axes.size(); ++a) {
    Axis& axis = axes[a];
    if (std::isfinite(axis.prior)) continue;
    const Parameter& p = model.parameters()[axis.parameter];
    const bool of_effect = p.info != nullptr && std::count(p.name.begin(), p.name.end(), '.') >= 2;
    if (!of_effect) {
      axis.center = axis.start;
      axis.prior = kOfRange * (axis.upper - axis.lower);
      continue;
    }
    const bool reads_effort = p.name.find(".effort_scale.") != std::string::npos;
    if (reads_effort) {
      axis.lower = std::max(axis.lower, -kMostScale * kScaleError);
      axis.upper = std::min(axis.upper, kMostScale * kScaleError);
    }
    axis.prior = reads_effort ? kScaleError : deviation(p, model, experiment);
    axis.center = is_strength(*p.info) ? to_search(axis.coordinate, p.neutral) : point[a];
  }
  space.replace(std::move(axes));
}

bool knows_a_mass(const PlantModel& model, const SearchSpace& space) {
  const auto& axes = space.axes();
  const auto parameter = [&](const Axis& axis) -> const Parameter& { return model.parameters()[axis.parameter]; };
  const bool total = space.dependent() >= 0 || !space.shared_masses().empty();
  const bool links = std::ranges::none_of(axes, [&](const Axis& axis) { return parameter(axis).key == "mass"; });
  return total || links || std::ranges::any_of(model.effects(), [&](const Component& effect) {
           const bool load = std::string(effect_table()[effect.type].name) == "payload";
           return load && std::ranges::none_of(axes, [&](const Axis& a) { return a.parameter == effect.first; });
         });
}

void carry_scale_error(const PlantModel& model, const SearchSpace& space, const Experiment& experiment,
                       std::vector<Estimate>& estimates) {
  const bool measured = std::ranges::any_of(experiment.channels,
                                            [](const Channel& channel) { return channel.kind == ChannelKind::effort; });
  if (!measured || knows_a_mass(model, space)) return;
  for (Estimate& e : estimates) {
    const int index = model.find(e.name);
    if (index < 0) continue;
    const Parameter& p = model.parameters()[index];
    if (p.key != "mass" && (p.info == nullptr || p.info->scale != Scale::mass)) continue;
    const double more = kNormal95 * kScaleError * e.value;
    e.lower95 = std::max(p.lower, e.value - std::hypot(e.value - e.lower95, more));
    e.upper95 = std::min(p.upper, e.value + std::hypot(e.upper95 - e.value, more));
  }
}

}  // namespace lacuna
