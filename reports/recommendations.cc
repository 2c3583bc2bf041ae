// What a comparison says to a person who must choose.
#include <algorithm>
#include <cmath>
#include <functional>

#include "reports/comparison.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

constexpr double kTarget = 1e-4;                 // rad (m), the accuracy at which computing times are compared
constexpr double kAsGood = 1.1;                  // figures within this factor of the best are as good
constexpr double kAccelerationRounding = 1e-10;  // relative: accelerations nearer than this are equally right

using Measure = std::function<double(const EngineComparison&)>;

/// Engines that were asked for, in order.
std::vector<std::string> engines_of(const Comparison& comparison) {
  std::vector<std::string> out;
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    for (const EngineComparison& engine : scenario.engines) {
      if (std::find(out.begin(), out.end(), engine.engine) == out.end()) out.push_back(engine.engine);
    }
  }
  return out;
}

/// Scenarios that every engine which can run any could run: else a refusal would look like speed.
std::vector<const ScenarioComparison*> shared(const Comparison& comparison) {
  std::vector<const ScenarioComparison*> out;
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    if (std::all_of(scenario.engines.begin(), scenario.engines.end(), [](const auto& e) { return e.available; }))
      out.push_back(&scenario);
  }
  if (!out.empty()) return out;
  for (const ScenarioComparison& scenario : comparison.scenarios) out.push_back(&scenario);
  return out;
}

std::vector<double> figures_of(const std::vector<const ScenarioComparison*>& scenarios, const std::string& name,
                               const Measure& figure) {
  std::vector<double> out;
  for (const ScenarioComparison* scenario : scenarios) {
    const EngineComparison* engine = scenario->find(name);
    const double value = engine != nullptr && engine->available ? figure(*engine) : kUnmeasured;
    if (!std::isnan(value)) out.push_back(value);
  }
  return out;
}

double median(std::vector<double> values) { return timing_of(std::move(values)).median; }
double worst(const std::vector<double>& values, bool least) {
  if (values.empty()) return kUnmeasured;
  return least ? *std::max_element(values.begin(), values.end()) : *std::min_element(values.begin(), values.end());
}

/// Least, or greatest, of the figures wins; within kAsGood of it is as good, and so is all that is below `enough`.
void choose(Recommendation& verdict, bool least, double enough = 0.0) {
  double best = kUnmeasured;
  for (const auto& [engine, value] : verdict.figures) {
    if (!std::isfinite(value)) continue;
    if (std::isnan(best) || (least ? value < best : value > best)) best = value;
  }
  for (const auto& [engine, value] : verdict.figures) {
    if (!std::isfinite(value)) continue;
    const bool as_good = least ? value <= std::max(best * kAsGood, enough) : value >= best / kAsGood;
    if (as_good) verdict.best.push_back(engine);
  }
}

struct Question {
  const char *need, *measure;
  Measure figure;
  bool worst_of;  ///< over the scenarios, else the median
  bool least;     ///< is best
  double enough;  ///< figures below are all as good
  const char* remark;
};

const MethodResult* default_integrator(const EngineComparison& engine) {
  const auto at = std::find_if(engine.methods.begin(), engine.methods.end(),
                               [](const MethodResult& method) { return method.native; });
  return at == engine.methods.end() || !at->not_run.empty() ? nullptr : &*at;
}

/// Least, or greatest, of a figure over the engine's own integrators.
double least_native(const EngineComparison& engine, double MethodResult::*figure, bool least = true) {
  double out = kUnmeasured;
  for (const MethodResult& method : engine.methods) {
    if (!method.native || !method.not_run.empty() || std::isnan(method.*figure)) continue;
    if (std::isnan(out) || (least ? method.*figure < out : method.*figure > out)) out = method.*figure;
  }
  return out;
}

/// Least computing time that reaches the target, over the methods asked for; infinity where none does.
double time_to_target(const EngineComparison& engine, bool native) {
  double out = HUGE_VAL;
  bool any = false;
  for (const MethodResult& method : engine.methods) {
    if (method.native != native || method.points.empty()) continue;
    any = true;
    for (const WorkPoint& point : method.points) {
      if (point.error <= kTarget) out = std::min(out, 1e3 * point.cpu_per_second);
    }
  }
  return any ? out : kUnmeasured;
}

bool all_bits(const EngineComparison& engine) {
  return std::all_of(engine.methods.begin(), engine.methods.end(), [](const MethodResult& method) {
    const bool checked = method.not_run.empty() && !(method.name == kAdaptiveMethod && !method.native);
    return !checked || (method.repeats && method.restores);
  });
}

std::vector<Question> questions() {
  return {
      {"many evaluations (identification, screening)", "ns an acceleration (q, v, tau) -> a, median over scenarios",
       [](const EngineComparison& e) { return e.forward_ns.median; }, false, true, 0.0,
       "one core, one parameter set at a time; Featherstone's SIMD lanes come on top and are not in this figure"},
      {"right accelerations", "largest relative error over the random states of all scenarios",
       [](const EngineComparison& e) { return e.acceleration_error.value; }, true, true, kAccelerationRounding,
       "against Featherstone's equations in extended precision; below 1e-10 all are called equal"},
      {"a motion to 1e-4 rad (m) by its own integrator", "ms of computing a second of motion, median over scenarios",
       [](const EngineComparison& e) { return time_to_target(e, true); }, false, true, 0.0,
       "cheapest of its integrators and of the steps tried; a dash: not reached"},
      {"a motion to 1e-4 rad (m) by a common integrator", "ms of computing a second of motion, median over scenarios",
       [](const EngineComparison& e) { return time_to_target(e, false); }, false, true, 0.0,
       "Kutta's fourth-order steps or Dormand and Prince's with step control, the same for all engines"},
      {"energy kept in free motion, own integrators",
       "worst over the scenarios of the best integrator's relative drift",
       [](const EngineComparison& e) { return least_native(e, &MethodResult::energy_drift); }, true, true, 1e-10,
       "at the comparison's step"},
      {"energy kept as it comes out of the box", "worst over the scenarios, relative, default integrator",
       [](const EngineComparison& e) {
         const MethodResult* method = default_integrator(e);
         return method == nullptr ? kUnmeasured : method->energy_drift;
       },
       true, true, 1e-10, "at the comparison's step"},
      {"long steps", "s, longest stable step of its integrators, least over the scenarios",
       [](const EngineComparison& e) { return least_native(e, &MethodResult::largest_stable_step, false); }, true,
       false, 0.0, "stable is not accurate; steps are tried in factors of two"},
      {"parameters changed often", "ns to change a body and evaluate, median over scenarios",
       [](const EngineComparison& e) { return e.set_inertial_ns.median + e.forward_ns.median; }, false, true, 0.0, ""},
      {"quick to build", "us, median over scenarios", [](const EngineComparison& e) { return e.build_us.median; },
       false, true, 0.0, ""},
      {"small", "bytes of heap a robot, median over scenarios",
       [](const EngineComparison& e) { return e.memory_bytes; }, false, true, 0.0, ""},
  };
}

Recommendation bits_verdict(const Comparison& comparison) {
  Recommendation out{
      "the same bits again", {}, "share of scenarios in which every integrator repeats and restores", {}, ""};
  for (const std::string& name : engines_of(comparison)) {
    int run = 0, kept = 0;
    for (const ScenarioComparison& scenario : comparison.scenarios) {
      const EngineComparison* engine = scenario.find(name);
      if (engine == nullptr || !engine->available) continue;
      ++run;
      kept += all_bits(*engine);
    }
    out.figures.emplace_back(name, run > 0 ? static_cast<double>(kept) / run : kUnmeasured);
    if (run > 0 && kept == run) out.best.push_back(name);
  }
  out.remark = "a second run, and a run resumed from a saved (q, v) on a fresh build";
  return out;
}

Recommendation identification_verdict(const Comparison& comparison) {
  Recommendation out{"identification", {}, "s of wall clock at the same budget, mean over the engines' data", {}, ""};
  for (const std::string& name : engines_of(comparison)) {
    double sum = 0.0;
    int fits = 0;
    for (const ScenarioComparison& scenario : comparison.scenarios) {
      for (const PairFit& pair : scenario.identification.pairs) {
        if (pair.engine == name) sum += pair.seconds, ++fits;
      }
    }
    out.figures.emplace_back(name, fits > 0 ? sum / fits : kUnmeasured);
  }
  choose(out, true);
  out.remark = "Featherstone runs parameter sets as SIMD lanes, the others one by one";
  return out;
}

}  // namespace

std::vector<Recommendation> recommendations(const Comparison& comparison) {
  const auto scenarios = shared(comparison);
  std::vector<Recommendation> out;
  for (const Question& question : questions()) {
    Recommendation verdict{question.need, {}, question.measure, {}, question.remark};
    for (const std::string& name : engines_of(comparison)) {
      const std::vector<double> values = figures_of(scenarios, name, question.figure);
      const double value = question.worst_of ? worst(values, question.least) : median(values);
      verdict.figures.emplace_back(name, std::isfinite(value) ? value : kUnmeasured);
    }
    choose(verdict, question.least, question.enough);
    out.push_back(std::move(verdict));
  }
  out.push_back(bits_verdict(comparison));
  const Recommendation fits = identification_verdict(comparison);
  if (!fits.best.empty()) out.push_back(fits);
  std::erase_if(out, [](const Recommendation& verdict) { return verdict.best.empty(); });
  return out;
}

}  // namespace lacuna
