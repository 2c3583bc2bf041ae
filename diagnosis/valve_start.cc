#include "diagnosis/valve_start.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <optional>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "ga/search_space.h"
#include "physics/effects/table.h"

namespace lacuna {
namespace {

constexpr double kNearlyAsGood = 1.05;  ///< energy left, over what the best of all leaves
constexpr int kEvaluations = 200;       ///< of the chart's misfit, from one start

/// A number of an effect on the command, as searched here.
struct ValveShape {
  const char* effect;
  std::size_t number;          ///< which of the effect's; beyond its first only together with that
  std::vector<double> starts;  ///< in units of the largest command, where it is a command
};
/// What bends a static curve of speed against command, in the order in which a command passes it.
const std::vector<ValveShape>& shapes() {
  static const std::vector<ValveShape> all{{"valve_offset", 0, {0.0}},
                                           {"valve_deadband", 0, {0.05, 0.15, 0.3, 0.45}},
                                           {"actuator_saturation", 0, {2.0, 0.7, 0.4}},
                                           {"actuator_saturation", 1, {8.0}},
                                           {"valve_asymmetry", 0, {0.0}}};
  return all;
}
using Subset = std::vector<std::size_t>;  ///< indices of shapes()

const ParameterInfo& info_of(const ValveShape& shape) {
  return effect_table()[find_effect(shape.effect)].parameters[shape.number];
}

/// Gain, then the number of every shape of a subset, commands over the largest one.
struct ValveCurve {
  Subset shapes_of;
  double largest = 1.0;

  double parameter(std::size_t k, const Eigen::VectorXd& x) const {
    const ParameterInfo& p = info_of(shapes()[shapes_of[k]]);
    double value = x(static_cast<Eigen::Index>(k) + 1) * (p.scale == Scale::ratio ? 1.0 : largest);
    if (p.lower >= 0.0) value = std::fabs(value);
    return std::clamp(value, p.lower, p.upper);
  }
  /// The effects with their numbers, in order; those that are no shapes neutral.
  std::vector<std::pair<std::size_t, std::vector<double>>> effects(const Eigen::VectorXd& x) const {
    std::vector<std::pair<std::size_t, std::vector<double>>> out;  // index in the table
    for (std::size_t k = 0; k < shapes_of.size(); ++k) {
      const ValveShape& shape = shapes()[shapes_of[k]];
      const std::size_t type = find_effect(shape.effect);
      if (shape.number == 0) {
        out.emplace_back(type, std::vector<double>{});
        for (const ParameterInfo& info : effect_table()[type].parameters) out.back().second.push_back(info.neutral);
      }
      out.back().second[shape.number] = parameter(k, x);
    }
    return out;
  }
  static double passed(double u, const std::vector<std::pair<std::size_t, std::vector<double>>>& effects) {
    JointView<double> s;
    s.u = u;
    for (const auto& [type, p] : effects) s.u = Effects::hooks<double>()[type].command(p.data(), s);
    return s.u;
  }
  /// Speeds at the knots for a gain of 1.
  Eigen::VectorXd at(const std::vector<double>& commands, const Eigen::VectorXd& x) const {
    const auto with = effects(x);
    Eigen::VectorXd out(commands.size());
    for (std::size_t k = 0; k < commands.size(); ++k) out(k) = passed(commands[k], with);
    return out;
  }
};

/// What a curve leaves of a chart, for Levenberg and Marquardt.
struct CurveMisfit {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };
  const ValveChart* chart;
  ValveCurve curve;
  int inputs() const { return static_cast<int>(curve.shapes_of.size()) + 1; }
  int values() const { return static_cast<int>(std::max<Eigen::Index>(chart->target.size(), inputs())); }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
    out.setZero();
    out.head(chart->target.size()) = x(0) * (chart->root.transpose() * curve.at(chart->command, x)) - chart->target;
    return 0;
  }
};

struct FittedCurve {
  ValveCurve curve;
  Eigen::VectorXd x;
  double energy = HUGE_VAL;
};

void improve(const CurveMisfit& misfit, const Eigen::VectorXd& start, FittedCurve& best) {
  Eigen::VectorXd x = start;
  const Eigen::VectorXd one = misfit.chart->root.transpose() * misfit.curve.at(misfit.chart->command, x);
  x(0) = one.dot(misfit.chart->target) / std::max(one.squaredNorm(), std::numeric_limits<double>::min());
  Eigen::NumericalDiff<CurveMisfit> function(misfit, 1e-6);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<CurveMisfit>> solver(function);
  solver.parameters.maxfev = kEvaluations;
  solver.minimize(x);
  Eigen::VectorXd left(misfit.values());
  misfit(x, left);
  const double energy = misfit.chart->energy + left.squaredNorm();
  if (energy < best.energy) best = {misfit.curve, x, energy};
}

/// Every combination of the starts of a subset's numbers.
FittedCurve fitted_curve(const ValveChart& chart, const Subset& subset) {
  const double largest = std::max(std::fabs(chart.command.front()), std::fabs(chart.command.back()));
  const CurveMisfit misfit{&chart, {subset, largest}};
  FittedCurve best;
  std::vector<Eigen::VectorXd> starts{Eigen::VectorXd::Zero(misfit.inputs())};
  for (std::size_t k = 0; k < subset.size(); ++k) {
    std::vector<Eigen::VectorXd> grown;
    for (const Eigen::VectorXd& x : starts) {
      for (const double start : shapes()[subset[k]].starts) {
        grown.push_back(x);
        grown.back()(static_cast<Eigen::Index>(k) + 1) = start;
      }
    }
    starts = std::move(grown);
  }
  for (const Eigen::VectorXd& x : starts) improve(misfit, x, best);
  return best;
}

/// Whether every further number stands right behind its effect's first.
bool is_whole(const Subset& subset) {
  for (std::size_t k = 0; k < subset.size(); ++k) {
    const bool further = shapes()[subset[k]].number > 0;
    if (further && (k == 0 || shapes()[subset[k - 1]].effect != std::string(shapes()[subset[k]].effect))) return false;
  }
  return true;
}

/// The fewest shapes that leave hardly more than all of them do.
FittedCurve simplest_curve(const ValveChart& chart) {
  std::vector<FittedCurve> all;
  for (unsigned bits = 0; bits < 1u << shapes().size(); ++bits) {
    Subset subset;
    for (std::size_t k = 0; k < shapes().size(); ++k)
      if (bits >> k & 1u) subset.push_back(k);
    if (is_whole(subset)) all.push_back(fitted_curve(chart, subset));
  }
  double least = HUGE_VAL;
  for (const FittedCurve& f : all) least = std::min(least, f.energy);
  std::erase_if(all, [&](const FittedCurve& f) { return f.energy > kNearlyAsGood * least; });
  return *std::ranges::min_element(all, [](const FittedCurve& a, const FittedCurve& b) {
    const std::size_t na = a.curve.shapes_of.size(), nb = b.curve.shapes_of.size();
    return na != nb ? na < nb : a.energy < b.energy;
  });
}

/// An effect (index in the table) with the numbers given, the others neutral.
EffectSpec with_numbers(std::size_t type, const std::string& place, const std::vector<double>& given) {
  const EffectInfo& info = effect_table()[type];
  EffectSpec out{info.name, place, {}, {}, info.name};
  for (std::size_t k = 0; k < info.parameters.size(); ++k)
    out.parameters[info.parameters[k].name] = k < given.size() ? given[k] : info.parameters[k].neutral;
  return out;
}
EffectSpec with_leading(const std::string& effect, const std::string& place, double value) {
  return with_numbers(static_cast<std::size_t>(find_effect(effect)), place, {value});
}

/// N m/rad (N/m), of a drive that integrates its flow; of the joint's usual size where the scenario gives it none.
double oil_spring(const PlantModel& model, const Experiment& experiment, int joint) {
  const Component& drive = model.actuators()[joint];
  const int stiffness = actuator_table()[drive.type].roles.stiffness;
  const double given = model.values()[drive.first + stiffness];
  return given > 0.0 ? given : typical_size(Scale::stiffness, model, experiment, joint, model.values());
}

/// One stop, or two that are a travel apart. The drive's flow ends there, so as stiff as its oil is stiff enough: what
/// is stiffer asks for short steps, and moves nothing.
std::optional<EffectSpec> stop_of(const ValveChart& chart, const std::string& place, double oil_spring) {
  const bool lower = std::isfinite(chart.stops[0]), upper = std::isfinite(chart.stops[1]);
  if (!lower && !upper) return std::nullopt;
  EffectSpec out = with_leading("end_stop", place, upper ? chart.stops[1] : chart.stops[0]);
  out.parameters["k"] = (upper ? 1.0 : -1.0) * oil_spring;
  if (lower && upper) out.parameters["travel"] = chart.stops[1] - chart.stops[0];
  return out;
}

/// Whether the drive takes up no more flow against this effect: then nobody can say how hard the contact is.
bool stops_the_flow(const PlantModel& model, const EffectSpec& spec) {
  const std::optional<int> joint = model.robot().find_joint(spec.place);
  const std::size_t type = find_effect(spec.effect);
  return joint && integrates_flow(model.actuators()[*joint].type) && Effects::hooks<double>()[type].taken != nullptr;
}

}  // namespace

ScreenedEffect start_at(const CurrentModel& current, const Experiment& experiment, const EffectSpec& spec) {
  ScreenedEffect out{{spec.effect, spec.place, {}, spec.recordings, spec.where}, {}, {}, 0.0, {}, 0, 0.0, {}};
  const EffectInfo& info = effect_table()[find_effect(spec.effect)];
  const bool stops_flow = stops_the_flow(current.model, spec);
  for (const ParameterInfo& p : info.parameters) {
    const double value = spec.parameters.at(p.name);
    if (p.structural || (p.optional && value == p.neutral) || (stops_flow && p.least > 0.0))
      out.spec.parameters[p.name] = value;
  }
  const PlantModel model = current.model.with_effects({out.spec});
  for (const Axis& axis : effect_axes(model, experiment, model.effects().back(), out.spec)) {
    const std::string& key = model.parameters()[axis.parameter].key;
    out.own.push_back(std::clamp(axis.at(spec.parameters.at(key)), axis.lower, axis.upper));
  }
  out.parameters = static_cast<int>(out.own.size());
  return out;
}

std::vector<ValveStart> valve_starts(const PlantModel& model, const Experiment& experiment) {
  std::vector<ValveStart> out;
  for (const ValveChart& free : valve_charts(model, experiment)) {
    // The fewest of delay and lag, likewise.
    ValveChart chart = free;
    for (const auto& [delay, lag] : {std::pair{false, true}, {true, false}, {false, false}}) {
      ValveChart fewer = valve_chart(experiment, free.joint, delay, lag);
      if (fewer.energy <= kNearlyAsGood * free.energy) chart = std::move(fewer);
    }
    const FittedCurve curve = simplest_curve(chart);
    const std::string& place = chart.name;
    ValveStart start{chart.joint, curve.x(0), {}};
    if (chart.delay > 0.0) start.effects.push_back(with_leading("input_delay", place, chart.delay));
    for (const auto& [type, numbers] : curve.curve.effects(curve.x))
      start.effects.push_back(with_numbers(type, place, numbers));
    if (chart.lag > 0.0) start.effects.push_back(with_leading("actuator_lag", place, chart.lag));
    if (std::optional<EffectSpec> stop = stop_of(chart, place, oil_spring(model, experiment, chart.joint)))
      start.effects.push_back(std::move(*stop));
    out.push_back(std::move(start));
  }
  return out;
}

}  // namespace lacuna
