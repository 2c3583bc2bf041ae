// Costs with known minima, and ways to evaluate them, for the tests of the optimisers.
#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "ga/optimizer.h"

namespace lacuna::test {

using PointCost = std::function<double(const std::vector<double>&)>;

/// Nine parameters like the seed's; the minima lie off the middle of the box.
inline Box nine_box() { return {std::vector<double>(9, -4.0), std::vector<double>(9, 6.0), {}}; }
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

inline constexpr double optimum = 0.7;

inline double sphere(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) sum += (v - optimum) * (v - optimum);
  return sum;
}

inline double rastrigin(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) {
    const double d = v - optimum;
    sum += d * d + 10.0 * (1.0 - std::cos(2.0 * std::numbers::pi * d));
  }
  return sum;
}

inline double rosenbrock(const std::vector<double>& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    sum += 100.0 * std::pow(x[i + 1] - x[i] * x[i], 2) + std::pow(1.0 - x[i], 2);
  }
  return sum;
}

inline BatchCost one_by_one(PointCost cost) {
  return [cost](std::span<const std::vector<double>> points, std::span<double> costs) {
    for (std::size_t i = 0; i < points.size(); ++i) costs[i] = cost(points[i]);
  };
}

/// Last point first.
inline BatchCost backwards(PointCost cost) {
  return [cost](std::span<const std::vector<double>> points, std::span<double> costs) {
    for (std::size_t i = points.size(); i-- > 0;) costs[i] = cost(points[i]);
  };
}

inline BatchCost threaded(PointCost cost, std::size_t threads) {
  return [cost, threads](std::span<const std::vector<double>> points, std::span<double> costs) {
    std::vector<std::jthread> pool;
    for (std::size_t t = 0; t < threads; ++t) {
      pool.emplace_back([=] {
        for (std::size_t i = t; i < points.size(); i += threads) costs[i] = cost(points[i]);
      });
    }
  };
}

/// A folder of its own for each test, gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lacuna_ga_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Equal to the last bit in everything but time.
inline bool same_run(const OptimizerResult& a, const OptimizerResult& b) {
  const auto same_record = [](const GenerationRecord& x, const GenerationRecord& y) {
    return x.best == y.best && x.median == y.median && x.mean == y.mean && x.diversity == y.diversity &&
           x.evaluations == y.evaluations;
  };
  return a.best == b.best && a.best_cost == b.best_cost && a.evaluations == b.evaluations &&
         std::equal(a.history.begin(), a.history.end(), b.history.begin(), b.history.end(), same_record);
}

/// Runs with a stop after `generations`, as Ctrl-C would.
template <typename Run>
OptimizerResult stopped_after(int generations, const std::filesystem::path& checkpoint, const Run& run) {
  std::atomic<bool> stop = false;
  int done = 0;
  RunControl control;
  control.checkpoint = checkpoint;
  control.stop = &stop;
  control.progress = [&](const Progress&) { stop = ++done >= generations; };
  return run(control);
}

}  // namespace lacuna::test
