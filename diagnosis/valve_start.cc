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
constexpr double kStiffStop = 100.0;    ///< typical sizes

/// A number of an effect on the command, as searched here.
struct ValveShape {
  const char* effect;
  std::vector<double> starts;  ///< in units of the largest command
};
/// What bends a static curve of speed against command, in the order in which a command passes it.
const std::vector<ValveShape>& shapes() {
  static const std::vector<ValveShape> all{{"valve_offset", {0.0}},
                                           {"valve_deadband", {0.05, 0.15, 0.3, 0.45}},
                                           {"actuator_saturation", {2.0, 0.7, 0.4}},
                                           {"valve_asymmetry", {0.0}}};
  return all;
}
using Subset = std::vector<std::size_t>;  ///< indices of shapes()

const EffectInfo& info_of_shape(std::size_t shape) {
  return effect_table()[static_cast<std::size_t>(find_effect(shapes()[shape].effect))];
}
bool is_relative(std::size_t shape) { return info_of_shape(shape).parameters.front().scale == Scale::ratio; }

/// Gain, then the leading number of every shape of a subset, commands over the largest one.
struct ValveCurve {
  Subset shapes_of;
  double largest = 1.0;

  double parameter(std::size_t k, const Eigen::VectorXd& x) const {
    const std::size_t shape = shapes_of[k];
    const ParameterInfo& p = info_of_shape(shape).parameters.front();
    double value = x(static_cast<Eigen::Index>(k) + 1) * (is_relative(shape) ? 1.0 : largest);
    if (p.lower >= 0.0) value = std::fabs(value);
    return std::clamp(value, p.lower, p.upper);
  }
  double passed(double u, const Eigen::VectorXd& x) const {
    JointView<double> s;
    s.u = u;
    for (std::size_t k = 0; k < shapes_of.size(); ++k) {
      std::vector<double> p;
      for (const ParameterInfo& info : info_of_shape(shapes_of[k]).parameters) p.push_back(info.neutral);
      p.front() = parameter(k, x);
      const auto type = static_cast<std::size_t>(find_effect(shapes()[shapes_of[k]].effect));
      s.u = Effects::hooks<double>()[type].command(p.data(), s);
    }
    return s.u;
  }
  /// Speeds at the knots for a gain of 1.
  Eigen::VectorXd at(const std::vector<double>& commands, const Eigen::VectorXd& x) const {
    Eigen::VectorXd out(static_cast<Eigen::Index>(commands.size()));
    for (std::size_t k = 0; k < commands.size(); ++k) out(static_cast<Eigen::Index>(k)) = passed(commands[k], x);
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

/// The fewest shapes that leave hardly more than all of them do.
FittedCurve simplest_curve(const ValveChart& chart) {
  std::vector<FittedCurve> all;
  for (unsigned bits = 0; bits < 1u << shapes().size(); ++bits) {
    Subset subset;
    for (std::size_t k = 0; k < shapes().size(); ++k)
      if (bits >> k & 1u) subset.push_back(k);
    all.push_back(fitted_curve(chart, subset));
  }
  double least = HUGE_VAL;
  for (const FittedCurve& f : all) least = std::min(least, f.energy);
  std::erase_if(all, [&](const FittedCurve& f) { return f.energy > kNearlyAsGood * least; });
  return *std::ranges::min_element(all, [](const FittedCurve& a, const FittedCurve& b) {
    const std::size_t na = a.curve.shapes_of.size(), nb = b.curve.shapes_of.size();
    return na != nb ? na < nb : a.energy < b.energy;
  });
}

/// An effect with all its numbers: the leading one given, the others neutral.
EffectSpec with_leading(const std::string& effect, const std::string& place, double value) {
  EffectSpec out{effect, place, {}, {}, effect};
  const EffectInfo& info = effect_table()[static_cast<std::size_t>(find_effect(effect))];
  for (const ParameterInfo& p : info.parameters) out.parameters[p.name] = p.neutral;
  out.parameters[info.parameters.front().name] = value;
  return out;
}

/// One stop, or two that are a travel apart, stiff beside all else.
std::optional<EffectSpec> stop_of(const ValveChart& chart, const std::string& place, double stiffness) {
  const bool lower = std::isfinite(chart.stops[0]), upper = std::isfinite(chart.stops[1]);
  if (!lower && !upper) return std::nullopt;
  EffectSpec out = with_leading("end_stop", place, upper ? chart.stops[1] : chart.stops[0]);
  out.parameters["k"] = (upper ? 1.0 : -1.0) * kStiffStop * stiffness;
  if (lower && upper) out.parameters["travel"] = chart.stops[1] - chart.stops[0];
  return out;
}

}  // namespace

ScreenedEffect start_at(const CurrentModel& current, const Experiment& experiment, const EffectSpec& spec) {
  ScreenedEffect out{{spec.effect, spec.place, {}, spec.recordings, spec.where}, {}, {}, 0.0, {}, 0, 0.0, {}};
  const EffectInfo& info = effect_table()[static_cast<std::size_t>(find_effect(spec.effect))];
  for (const ParameterInfo& p : info.parameters) {
    if (p.optional && spec.parameters.at(p.name) == p.neutral) out.spec.parameters[p.name] = p.neutral;
  }
  const PlantModel model = current.model.with_effects({out.spec});
  for (const Axis& axis : effect_axes(model, experiment, model.effects().back(), out.spec)) {
    const std::string& key = model.parameters()[static_cast<std::size_t>(axis.parameter)].key;
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
    for (std::size_t k = 0; k < curve.curve.shapes_of.size(); ++k)
      start.effects.push_back(
          with_leading(shapes()[curve.curve.shapes_of[k]].effect, place, curve.curve.parameter(k, curve.x)));
    if (chart.lag > 0.0) start.effects.push_back(with_leading("actuator_lag", place, chart.lag));
    const double stiffness = typical_size(Scale::stiffness, model, experiment, chart.joint, model.values());
    if (std::optional<EffectSpec> stop = stop_of(chart, place, stiffness)) start.effects.push_back(std::move(*stop));
    out.push_back(std::move(start));
  }
  return out;
}

}  // namespace lacuna
