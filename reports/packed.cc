#include "reports/packed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSteps = 1e5;       // at least, over the range
constexpr std::size_t kPlain = 200;  // values that are written as they are

}  // namespace

Json six_digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

Json packed(std::span<const double> values, bool log) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double v : values)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  const double range = high - low;
  Json out = Json::array();
  if (log || values.size() <= kPlain || !(range > 1e-300) || !(range < 1e300)) {
    for (const double v : values) out.push_back(six_digits(v));
    return out;
  }
  const double step = std::pow(10.0, std::floor(std::log10(range / kSteps)));
  long last = 0;
  for (const double v : values) {
    if (!std::isfinite(v)) {
      out.push_back(nullptr);
      continue;
    }
    const long at = std::lround((v - low) / step);
    out.push_back(at - last);
    last = at;
  }
  return {{"from", low}, {"step", step}, {"d", std::move(out)}};
}

}  // namespace lacuna
