#include "compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lacuna {

double worse(double a, double b) {
  if (std::isnan(a)) return a;
  return b <= a ? a : b;
}

Timing timing_of(std::vector<double> values) {
  Timing out;
  out.repeats = static_cast<int>(values.size());
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto i = static_cast<std::size_t>(place);
    const double rest = place - static_cast<double>(i);
    return i + 1 < values.size() ? (1.0 - rest) * values[i] + rest * values[i + 1] : values[i];
  };
  out.low = at(0.25);
  out.median = at(0.5);
  out.high = at(0.75);
  return out;
}

void WorstSeen::see(double candidate, const std::string& at) {
  if (std::isnan(candidate)) candidate = HUGE_VAL;
  if (!std::isnan(value) && candidate <= value) return;
  value = candidate;
  where = at;
}

bool EngineComparison::has_method(const std::string& name) const {
  return std::any_of(methods.begin(), methods.end(), [&](const MethodResult& m) { return m.name == name; });
}

const MethodResult& EngineComparison::method(const std::string& name) const {
  const auto at = std::find_if(methods.begin(), methods.end(), [&](const MethodResult& m) { return m.name == name; });
  if (at == methods.end()) throw std::out_of_range("EngineComparison: no method " + name);
  return *at;
}

const EngineComparison* ScenarioComparison::find(const std::string& engine) const {
  const auto at =
      std::find_if(engines.begin(), engines.end(), [&](const EngineComparison& e) { return e.engine == engine; });
  return at == engines.end() ? nullptr : &*at;
}

}  // namespace lacuna
