#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/comparison.h"
#include "reports/json.h"
#include "reports/json_text.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kCurvePoints = 200;  // of an error over time

Json json_of(const Timing& timing) {
  return {{"median", timing.median}, {"low", timing.low}, {"high", timing.high}, {"repeats", timing.repeats}};
}

Json json_of(const WorkPoint& point) {
  Json out;
  if (std::isfinite(point.step)) out["step"] = point.step;
  if (std::isfinite(point.tolerance)) out["tolerance"] = point.tolerance;
  out["error"] = point.error;
  out["steps_per_second"] = point.steps_per_second;
  out["cpu_seconds_per_second"] = point.cpu_per_second;
  out["stable"] = point.stable;
  return out;
}

/// The worst of each stretch, so that no peak is lost.
Json curve_of(const MethodResult& method) {
  Json times = Json::array(), errors = Json::array();
  const std::size_t n = method.time.size(), stretches = std::min(n, kCurvePoints);
  for (std::size_t s = 0; s < stretches; ++s) {
    const auto begin = method.error.begin() + static_cast<std::ptrdiff_t>(s * n / stretches);
    const auto end = method.error.begin() + static_cast<std::ptrdiff_t>((s + 1) * n / stretches);
    const auto worst = std::max_element(begin, end);
    times.push_back(method.time[worst - method.error.begin()]);
    errors.push_back(*worst);
  }
  return {{"time", times}, {"error", errors}};
}

Json points_of(const MethodResult& method) {
  Json points = Json::array();
  for (const WorkPoint& point : method.points) points.push_back(json_of(point));
  return {{"method", method.name}, {"native", method.native}, {"points", points}};
}

Json json_of(const MethodResult& method) {
  Json out{{"method", method.name}, {"native", method.native}};
  if (!method.not_run.empty()) {
    out["not_run"] = method.not_run;
    return out;
  }
  out["work_precision"] = points_of(method)["points"];
  if (!method.native && method.name == kAdaptiveMethod) return out;
  out["order"] = method.order;
  out["order_in_free_motion"] = method.order_free;
  out["largest_stable_step"] = method.largest_stable_step;
  out["stable_at_longest_step_tried"] = method.stable_at_longest;
  out["trajectory_seconds"] = method.trajectory_seconds;
  out["trajectory_error"] = method.trajectory_error;
  out["trajectory_error_rms"] = method.trajectory_error_rms;
  out["trajectory_error_worst_at"] = {{"time", method.trajectory_worst_time}, {"joint", method.trajectory_worst_joint}};
  out["energy_drift"] = method.energy_drift;
  out["momentum_drift"] = method.momentum_drift;
  out["ns_per_step"] = method.ns_per_step.median;
  out["ns_per_step_spread"] = json_of(method.ns_per_step);
  out["realtime_factor"] = method.realtime_factor;
  out["repeats_bitwise"] = method.repeats;
  out["restores_bitwise"] = method.restores;
  out["error_over_time"] = curve_of(method);
  return out;
}

Json json_of(const WorstSeen& worst) { return {{"value", worst.value}, {"where", worst.where}}; }

/// The figures that every record of an engine carries, by the method that is the same for all.
Json headline_of(const EngineComparison& engine) {
  const MethodResult& common = engine.method(kCommonMethod);
  return {{"max_acceleration_difference", engine.acceleration_difference.value},
          {"trajectory_error", common.trajectory_error},
          {"energy_drift", common.energy_drift},
          {"ns_per_step", common.ns_per_step.median},
          {"realtime_factor", common.realtime_factor}};
}

Json json_of(const EngineComparison& engine) {
  Json out{{"engine", engine.engine}, {"version", engine.version}, {"available", engine.available}};
  if (!engine.available) {
    out["reason"] = engine.reason;
    return out;
  }
  out.update(headline_of(engine));
  out["acceleration_states"] = engine.states;
  out["acceleration_difference"] = json_of(engine.acceleration_difference);
  out["acceleration_error"] = json_of(engine.acceleration_error);
  out["pose_difference"] = json_of(engine.pose_difference);
  out["forward_dynamics_ns"] = json_of(engine.forward_ns);
  out["set_inertial_ns"] = json_of(engine.set_inertial_ns);
  out["build_us"] = json_of(engine.build_us);
  out["memory_bytes"] = engine.memory_bytes;
  out["constraint_drift"] = Json::array();
  for (const JointDrift& drift : engine.joint_drift)
    out["constraint_drift"].push_back(
        {{"settings", drift.settings}, {"distance", drift.distance}, {"angle", drift.angle}});
  out["work_precision"] = Json::array();
  out["methods"] = Json::array();
  for (const MethodResult& method : engine.methods) {
    if (method.not_run.empty()) out["work_precision"].push_back(points_of(method));
    out["methods"].push_back(json_of(method));
  }
  return out;
}

Json map_of(const std::vector<std::pair<std::string, double>>& values) {
  Json out = Json::object();
  for (const auto& [name, value] : values) out[name] = value;
  return out;
}

Json json_of(const PairFits& fits) {
  if (!fits.not_run.empty()) return {{"not_run", fits.not_run}};
  Json pairs = Json::array();
  for (const PairFit& pair : fits.pairs)
    pairs.push_back({{"data_from", pair.data_engine},
                     {"identified_on", pair.engine},
                     {"parameters", map_of(pair.values)},
                     {"parameter_error", pair.parameter_error},
                     {"output_rms", pair.output_rms},
                     {"evaluations", pair.evaluations},
                     {"seconds", pair.seconds}});
  return {{"budget", fits.budget},
          {"data_seconds", fits.duration},
          {"residual_weight", fits.weight},
          {"truth", map_of(fits.truth)},
          {"pairs", pairs}};
}

Json json_of(const ScenarioComparison& scenario) {
  Json engines = Json::array();
  for (const EngineComparison& engine : scenario.engines) engines.push_back(json_of(engine));
  return {{"scenario", scenario.name},
          {"file", scenario.file},
          {"motion", scenario.motion},
          {"dof", scenario.dof},
          {"commanded", scenario.commanded},
          {"duration", scenario.duration},
          {"step", scenario.step},
          {"window", scenario.window},
          {"referee",
           {{"method", scenario.referee.method},
            {"tolerance", scenario.referee.tolerance},
            {"error", scenario.referee.error},
            {"trusted_until", scenario.referee.trusted_until},
            {"cpu_seconds", scenario.referee.seconds}}},
          {"engines", engines},
          {"identification", json_of(scenario.identification)},
          {"notes", scenario.notes},
          {"seconds", scenario.seconds}};
}

/// Larger of the two, NaN losing to any number.
double larger(double a, double b) { return std::isnan(a) || b > a ? b : a; }

/// One engine over all scenarios: the worst errors, the median times.
Json summary_of(const Comparison& comparison, const EngineInfo& info) {
  Json out{{"engine", info.name}, {"version", info.version}, {"available", false}};
  double acceleration = kUnmeasured, trajectory = kUnmeasured, energy = kUnmeasured;
  std::vector<double> ns, factor;
  Json work = Json::array(), refused = Json::array();
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    const EngineComparison* engine = scenario.find(info.name);
    if (engine == nullptr) continue;
    if (!engine->available) {
      refused.push_back({{"scenario", scenario.name}, {"reason", engine->reason}});
      continue;
    }
    out["available"] = true;
    const MethodResult& common = engine->method(kCommonMethod);
    acceleration = larger(acceleration, engine->acceleration_difference.value);
    trajectory = larger(trajectory, common.trajectory_error);
    energy = larger(energy, common.energy_drift);
    ns.push_back(common.ns_per_step.median);
    factor.push_back(common.realtime_factor);
    for (const MethodResult& method : engine->methods) {
      if (!method.not_run.empty()) continue;
      Json points = points_of(method);
      points["scenario"] = scenario.name;
      work.push_back(points);
    }
  }
  out["max_acceleration_difference"] = acceleration;
  out["trajectory_error"] = trajectory;
  out["energy_drift"] = energy;
  out["ns_per_step"] = timing_of(ns).median;
  out["realtime_factor"] = timing_of(factor).median;
  out["work_precision"] = work;
  if (!refused.empty()) out["refused"] = refused;
  out["own_models"] = Json::object();
  for (const OwnModel& model : info.own_models) out["own_models"][model.quantity] = model.words;
  return out;
}

Json json_of(const Recommendation& verdict) {
  Json out{{"need", verdict.need}, {"best", verdict.best}, {"measure", verdict.measure}};
  out["figures"] = map_of(verdict.figures);
  if (!verdict.remark.empty()) out["remark"] = verdict.remark;
  return out;
}

Json json_of(const Baseline& baseline) {
  if (baseline.empty()) return nullptr;
  Json changes = Json::array();
  for (const Change& change : baseline.changes)
    changes.push_back({{"scenario", change.scenario},
                       {"engine", change.engine},
                       {"quantity", change.quantity},
                       {"before", change.before},
                       {"after", change.after},
                       {"beyond_factor", change.limit},
                       {"better", change.better}});
  return {{"file", baseline.file},
          {"date", baseline.date},
          {"commit", baseline.commit},
          {"figures_compared", baseline.compared},
          {"changes", changes}};
}

bool compared(const Comparison& comparison, const std::string& engine) {
  return std::any_of(comparison.scenarios.begin(), comparison.scenarios.end(),
                     [&](const ScenarioComparison& scenario) { return scenario.find(engine) != nullptr; });
}

}  // namespace

std::string to_json(const Comparison& comparison, const Baseline& baseline, const Context& context) {
  Json names = Json::array(), engines = Json::array(), scenarios = Json::array(), said = Json::array();
  for (const EngineInfo& info : comparison.engines)
    if (compared(comparison, info.name)) engines.push_back(summary_of(comparison, info));
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    names.push_back(scenario.name);
    scenarios.push_back(json_of(scenario));
  }
  for (const Recommendation& verdict : recommendations(comparison)) said.push_back(json_of(verdict));
  const Json out{{"format", "lacuna-compare/1"},
                 {"scenario", names.size() == 1 ? names.front() : names},
                 {"seed", context.seed},
                 {"version", context.version},
                 {"verdict", said},
                 {"engines", engines},
                 {"scenarios", scenarios},
                 {"baseline", json_of(baseline)},
                 {"seconds", comparison.seconds},
                 {"context", Json::parse(to_json(context))}};
  return json_text(out);
}

}  // namespace lacuna
