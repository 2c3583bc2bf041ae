#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/comparison.h"
#include "scenarios/error.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTimingFloor = 1.10;     // factor: frequency and placement differ by as much from run to run
constexpr double kSpreads = 3.0;          // of both runs' quartiles
constexpr double kAccuracyFactor = 1.1;   // errors are deterministic on one machine; compilers move their last digits
constexpr double kErrorRounding = 1e-11;  // errors below are rounding's

/// One figure of one run.
struct Figure {
  double value = kUnmeasured;
  double spread = 0.0;  ///< quartiles apart over the median; timings only
  bool timing = false;
};
using Figures = std::map<std::string, Figure>;  ///< quantity -> figure

double number_of(const Json& json, const char* key) {
  const auto at = json.find(key);
  return at != json.end() && at->is_number() ? at->get<double>() : kUnmeasured;
}

Figure timing_in(const Json& json, const char* key) {
  Figure out;
  out.timing = true;
  const auto at = json.find(key);
  if (at == json.end() || !at->is_object()) return out;
  out.value = number_of(*at, "median");
  out.spread = (number_of(*at, "high") - number_of(*at, "low")) / out.value;
  return out;
}

/// Timings in units of `unit`.
void scale_timings(Figures& figures, const Figure& unit) {
  for (auto& [quantity, figure] : figures) {
    if (!figure.timing) continue;
    figure.value /= unit.value;
    figure.spread += unit.spread;
  }
}

Figures figures_of(const Json& engine) {
  Figures out;
  const auto error = [&](const std::string& name, double value) { out[name] = {value, 0.0, false}; };
  error("acceleration error", number_of(engine.value("acceleration_error", Json::object()), "value"));
  for (const char* key : {"forward_dynamics_ns", "set_inertial_ns", "build_us"}) out[key] = timing_in(engine, key);
  for (const Json& method : engine.value("methods", Json::array())) {
    const std::string name = std::string(method.value("native", false) ? "own " : "common ") +
                             method.value("method", std::string("?")) + ": ";
    for (const char* key : {"trajectory_error", "energy_drift", "momentum_drift"})
      error(name + key, number_of(method, key));
    out[name + "ns_per_step"] = timing_in(method, "ns_per_step_spread");
  }
  return out;
}

/// scenario -> engine -> figures, timings relative to Featherstone's evaluation.
std::map<std::string, std::map<std::string, Figures>> figures_in(const Json& document) {
  std::map<std::string, std::map<std::string, Figures>> out;
  for (const Json& scenario : document.at("scenarios")) {
    auto& engines = out[scenario.at("scenario").get<std::string>()];
    Figure unit{1.0, 0.0, true};
    for (const Json& engine : scenario.at("engines")) {
      const Figure forward = timing_in(engine, "forward_dynamics_ns");
      if (engine.at("engine") == "featherstone" && forward.value > 0.0) unit = forward;
    }
    for (const Json& engine : scenario.at("engines")) {
      if (!engine.value("available", false)) continue;
      Figures figures = figures_of(engine);
      scale_timings(figures, unit);
      engines[engine.at("engine").get<std::string>()] = std::move(figures);
    }
  }
  return out;
}

/// Factor that a change must exceed, or 0 where the pair says nothing.
double limit_of(const Figure& before, const Figure& after) {
  if (!(before.value > 0.0) || !(after.value > 0.0)) return 0.0;
  if (!std::isfinite(before.value) || !std::isfinite(after.value)) return 0.0;
  if (!before.timing) return std::max(before.value, after.value) > kErrorRounding ? kAccuracyFactor : 0.0;
  return std::max(kTimingFloor, 1.0 + kSpreads * (std::fabs(before.spread) + std::fabs(after.spread)));
}

Json parsed(const std::string& text, const std::string& file) {
  const Json document = Json::parse(text, nullptr, false);
  if (document.is_discarded() || !document.is_object() || document.value("format", Json()) != "lacuna-compare/1")
    throw InputError(file, document.is_discarded() ? "no JSON" : "JSON of another kind",
                     "a compare.json (format lacuna-compare/1)");
  return document;
}

}  // namespace

Baseline changes_since(const std::string& old_json, const std::string& file, const Comparison& now) {
  const Json old_document = parsed(old_json, file);
  Baseline out;
  out.file = file;
  try {
    const Json context = old_document.value("context", Json::object());
    out.date = context.value("date", std::string());
    out.commit = context.value("commit", std::string());
    const auto before = figures_in(old_document);
    for (const auto& [scenario, engines] : figures_in(Json::parse(to_json(now, {}, Context{})))) {
      for (const auto& [engine, figures] : engines) {
        for (const auto& [quantity, figure] : figures) {
          const auto in_scenario = before.find(scenario);
          if (in_scenario == before.end()) continue;
          const auto in_engine = in_scenario->second.find(engine);
          if (in_engine == in_scenario->second.end()) continue;
          const auto old = in_engine->second.find(quantity);
          if (old == in_engine->second.end()) continue;
          ++out.compared;
          const double limit = limit_of(old->second, figure);
          const double factor = figure.value / old->second.value;
          if (limit == 0.0 || (factor < limit && factor > 1.0 / limit)) continue;
          out.changes.push_back({scenario, engine, quantity, old->second.value, figure.value, limit, factor < 1.0});
        }
      }
    }
  } catch (const Json::exception& error) {
    throw InputError(file, "a compare.json with something amiss in it (" + quoted(error.what(), 120) + ")",
                     "one as lacuna compare writes it");
  }
  return out;
}

}  // namespace lacuna
