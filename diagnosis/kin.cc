#include "diagnosis/kin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace lacuna {
namespace {

/// From the starts that the catalogue gives towards neutral, which may be at infinity: a search that begins at the
/// simpler effect begins near it.
constexpr std::array kFractions{1.0, 0.3, 0.1, 0.03, 0.01};

std::set<std::pair<std::string, std::string>> numbers_of(const EffectInfo& info) {
  std::set<std::pair<std::string, std::string>> out;
  for (const ParameterInfo& p : info.parameters) {
    if (!p.optional) out.emplace(p.name, p.unit);
  }
  return out;
}

/// Values of the effect's free parameters by name, as found.
std::map<std::string, double> found_values(const ScreenedEffect& source, const CurrentModel& model) {
  std::map<std::string, double> out;
  const auto& axes = model.space.axes();
  const std::size_t first = axes.size() - source.own.size();
  for (std::size_t k = 0; k < source.own.size(); ++k) {
    const Axis& axis = axes[first + k];
    const Parameter& p = model.model.parameters()[axis.parameter];
    out[p.info->name] = from_search(axis.coordinate, source.own[k]);
  }
  return out;
}

/// Own coordinates: those found by name, and every combination of starts for the others.
std::vector<std::vector<double>> grid(const std::vector<Axis>& axes, const PlantModel& model,
                                      const Experiment& experiment, const std::map<std::string, double>& found) {
  std::vector<std::vector<double>> points{{}};
  for (const Axis& axis : axes) {
    const Parameter& p = model.parameters()[axis.parameter];
    std::vector<double> values;
    if (const auto known = found.find(p.info->name); known != found.end()) {
      values.push_back(known->second);
    } else {
      const double size = typical_size(p.info->scale, model, experiment, p.joint, model.values());
      const double origin = typical_origin(p.info->scale, experiment, p.joint);
      for (const double start : p.info->starts) {
        for (const double fraction : kFractions) {
          const double nearer = std::isinf(p.neutral) ? 1.0 / fraction : fraction;
          values.push_back(origin + nearer * start * size);
        }
      }
    }
    std::vector<std::vector<double>> grown;
    for (const std::vector<double>& point : points) {
      for (const double value : values) {
        grown.push_back(point);
        grown.back().push_back(std::clamp(to_search(axis.coordinate, value), axis.lower, axis.upper));
      }
    }
    points = std::move(grown);
  }
  return points;
}

/// `spec` at the point of the grid that leaves least.
std::optional<ScreenedEffect> best_start(const EffectSpec& spec, const ScreenedEffect& source,
                                         const std::map<std::string, double>& found, const CurrentModel& current,
                                         const FitContext& context) {
  const CurrentModel there = extended(current, context.experiment, spec, source.point, {});
  const std::size_t base = current.space.size();
  const std::vector<Axis> axes(there.space.axes().begin() + static_cast<std::ptrdiff_t>(base),
                               there.space.axes().end());
  std::vector<std::vector<double>> points = grid(axes, there.model, context.experiment, found);
  for (std::vector<double>& point : points) point.insert(point.begin(), source.point.begin(), source.point.end());
  Problem problem = problem_of(there, context, current.weights);
  const std::vector<Eigen::VectorXd> residuals = problem.residuals(points, context.experiment.with_role(Role::train));
  std::optional<ScreenedEffect> best;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double energy = residuals[k].squaredNorm();
    if (!std::isfinite(energy) || (best && energy >= best->sum_of_squares)) continue;
    const std::vector<double> own(points[k].begin() + static_cast<std::ptrdiff_t>(base), points[k].end());
    best = ScreenedEffect{spec, source.point, own, energy, residuals[k], static_cast<int>(own.size()), energy, own};
  }
  return best;
}

}  // namespace

bool are_kin(const EffectInfo& one, const EffectInfo& other) {
  const auto a = numbers_of(one), b = numbers_of(other);
  return a != b && one.where == other.where &&
         (std::includes(a.begin(), a.end(), b.begin(), b.end()) ||
          std::includes(b.begin(), b.end(), a.begin(), a.end()));
}

bool overlap(const EffectInfo& one, const EffectInfo& other) {
  if (one.in_parallel || other.in_parallel) return false;
  const auto is = [](const char* name, const EffectInfo& info) {
    return name != nullptr && name == std::string(info.name);
  };
  if (are_kin(one, other) || is(one.generalises, other) || is(other.generalises, one)) return true;
  return std::any_of(effect_table().begin(), effect_table().end(), [&](const EffectInfo& third) {
    return are_kin(one, third) && are_kin(other, third) &&
           third.parameters.size() < std::min(one.parameters.size(), other.parameters.size());
  });
}

std::vector<ScreenedEffect> kin_starts(const EffectInfo& kin, const ScreenedEffect& source, const CurrentModel& model,
                                       const CurrentModel& current, const FitContext& context) {
  const std::map<std::string, double> found = found_values(source, model);
  EffectSpec spare{kin.name, source.spec.place, {}, source.spec.recordings, kin.name}, shaped = spare;
  for (const ParameterInfo& p : kin.parameters) {
    if (!p.optional) continue;
    spare.parameters[p.name] = p.neutral;
    if (found.count(p.name) == 0) shaped.parameters[p.name] = p.neutral;
  }
  std::vector<EffectSpec> variants{spare};
  if (shaped.parameters != spare.parameters) variants.push_back(shaped);
  std::vector<ScreenedEffect> out;
  for (const EffectSpec& spec : variants) {
    if (auto start = best_start(spec, source, found, current, context)) out.push_back(std::move(*start));
  }
  return out;
}

}  // namespace lacuna
