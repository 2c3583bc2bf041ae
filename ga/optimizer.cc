#include "ga/optimizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace lacuna {
namespace {

std::string parameter_name(const Box& box, std::size_t i) {
  return box.names.empty() ? fmt::format("parameter {}", i) : box.names[i];
}

}  // namespace

void validate(const Box& box) {
  const std::size_t n = box.lower.size();
  if (n == 0) throw std::invalid_argument("box: no parameter, allowed: at least one");
  if (box.upper.size() != n || (!box.names.empty() && box.names.size() != n)) {
    throw std::invalid_argument(fmt::format("box: {} lower bounds, {} upper bounds, {} names, allowed: equal numbers",
                                            n, box.upper.size(), box.names.size()));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double lower = box.lower[i], upper = box.upper[i];
    // Decoding multiplies the width by a 16-bit integer, which must not overflow.
    if (!std::isfinite(lower) || !std::isfinite(upper) || !(lower < upper) ||
        !std::isfinite(65536.0 * (upper - lower))) {
      throw std::invalid_argument(fmt::format("box: {} has bounds [{}, {}], allowed: finite, lower < upper",
                                              parameter_name(box, i), lower, upper));
    }
  }
}

void validate_points(const std::string& option, std::span<const std::vector<double>> points, const Box& box) {
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (points[p].size() != box.lower.size()) {
      throw std::invalid_argument(
          fmt::format("{}: point {} has {} values, allowed: {}", option, p, points[p].size(), box.lower.size()));
    }
    for (std::size_t i = 0; i < points[p].size(); ++i) {
      if (points[p][i] >= box.lower[i] && points[p][i] <= box.upper[i]) continue;
      throw std::invalid_argument(fmt::format("{}: point {} has {} = {}, allowed: {} .. {}", option, p,
                                              parameter_name(box, i), points[p][i], box.lower[i], box.upper[i]));
    }
  }
}

RunControl RunControl::quiet() const {
  RunControl out = *this;
  out.progress = nullptr;
  out.checkpoint.clear();
  return out;
}

double diversity(std::span<const std::vector<double>> points, const Box& box) {
  if (points.empty()) return 0.0;
  const double count = static_cast<double>(points.size());
  double total = 0.0;
  for (std::size_t i = 0; i < box.lower.size(); ++i) {
    const double width = box.upper[i] - box.lower[i];
    double mean = 0.0, variance = 0.0;
    for (const auto& point : points) mean += (point[i] - box.lower[i]) / width;
    mean /= count;
    for (const auto& point : points) variance += std::pow((point[i] - box.lower[i]) / width - mean, 2);
    total += std::sqrt(12.0 * variance / count);
  }
  return total / static_cast<double>(box.lower.size());
}

GenerationRecord record_generation(std::span<const std::vector<double>> points, std::span<const double> costs,
                                   const Box& box, double best_so_far, long evaluations, double seconds) {
  GenerationRecord record{.best = best_so_far,
                          .median = std::numeric_limits<double>::infinity(),
                          .mean = std::numeric_limits<double>::infinity(),
                          .diversity = diversity(points, box),
                          .evaluations = evaluations,
                          .seconds = seconds};
  std::vector<double> valid;
  std::copy_if(costs.begin(), costs.end(), std::back_inserter(valid), [](double c) { return std::isfinite(c); });
  if (valid.empty()) return record;
  std::sort(valid.begin(), valid.end());
  const std::size_t half = valid.size() / 2;
  record.median = valid.size() % 2 == 1 ? valid[half] : 0.5 * valid[half - 1] + 0.5 * valid[half];
  record.mean = std::accumulate(valid.begin(), valid.end(), 0.0) / static_cast<double>(valid.size());
  return record;
}

std::vector<double> evaluate(const BatchCost& cost, std::span<const std::vector<double>> points) {
  std::vector<double> costs(points.size(), std::numeric_limits<double>::infinity());
  if (!points.empty()) cost(points, costs);
  for (double& c : costs) {
    if (!std::isfinite(c)) c = std::numeric_limits<double>::infinity();
  }
  return costs;
}

}  // namespace lacuna
