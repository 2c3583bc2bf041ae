#include "diagnosis/free_number.h"

#include <algorithm>

#include "ga/problem.h"

namespace lacuna {
namespace {

const Component& component_of(const PlantModel& model, const EffectSpec& member) {
  return model.effects()[model.find_effect_at(member.effect, member.place)];
}

/// The number's starts, with the model's values there.
void add_starts(const CurrentModel& now, const Experiment& experiment, const FreeNumber& number,
                std::vector<FreeNumber>& starts, std::vector<std::vector<double>>& values) {
  const std::vector<double> plain = now.space.expand(now.fit.point);
  for (const Axis& axis : effect_axes(now.model, experiment, component_of(now.model, number.member), number.with)) {
    const std::size_t index = axis.parameter;
    if (now.model.parameters()[index].key != number.key) continue;
    for (const std::vector<double>& start : starting_points(now.model, experiment, {axis})) {
      starts.push_back(number);
      starts.back().start = std::clamp(start.front(), axis.lower, axis.upper);
      values.push_back(plain);
      values.back()[index] = from_search(axis.coordinate, starts.back().start);
    }
  }
}

}  // namespace

std::vector<FreeNumber> numbers_to_free(const Hypothesis& set, const FitContext& context) {
  const CurrentModel& now = set.model;
  std::vector<FreeNumber> out;
  std::vector<std::vector<double>> values;
  for (const EffectSpec& spec : set.effects) {
    for (const ParameterInfo& p : effect_info(spec.effect).parameters) {
      if (!p.optional || spec.parameters.count(p.name) == 0) continue;
      FreeNumber number{spec, spec, p.name, 0.0, {}};
      number.with.parameters.erase(p.name);
      add_starts(now, context.experiment, number, out, values);
    }
  }
  if (out.empty()) return out;
  Problem problem = problem_of(now, context);
  std::vector<Eigen::VectorXd> residuals = problem.residuals_of(values, context.experiment.with_role(Role::train));
  for (std::size_t k = 0; k < out.size(); ++k) out[k].residual = std::move(residuals[k]);
  return out;
}

std::vector<double> own_point_with(const CurrentModel& now, const Experiment& experiment, const EffectSpec& member,
                                   const EffectSpec& with, double start) {
  const std::vector<double> values = now.space.expand(now.fit.point);
  std::vector<double> out;
  for (const Axis& axis : effect_axes(now.model, experiment, component_of(now.model, member), with)) {
    const std::size_t index = axis.parameter;
    const bool fresh = member.parameters.count(now.model.parameters()[index].key) > 0;
    out.push_back(fresh ? start : to_search(axis.coordinate, values[index]));
  }
  return out;
}

}  // namespace lacuna
