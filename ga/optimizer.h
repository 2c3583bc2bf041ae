// The one call behind which all optimisers stand: a box, a cost of many points at once, and how a run is watched,
// stopped and resumed.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace lacuna {

/// The space searched: one closed interval per parameter, in the parameter's own unit.
struct Box {
  std::vector<double> lower, upper;
  std::vector<std::string> names;  ///< for messages; empty or one per parameter
};

/// Throws std::invalid_argument unless the box has a dimension, equal lengths, finite bounds and lower < upper.
void validate(const Box& box);

/// Throws std::invalid_argument, naming point and parameter, unless every point has the box's length and lies in it.
void validate_points(const std::string& option, std::span<const std::vector<double>> points, const Box& box);

/// Writes the cost of every point (lower is better; NaN and infinity: failed, ranked last). Called from one thread; the
/// callee may use all. The cost of a point must not depend on the other points, nor on time.
using BatchCost = std::function<void(std::span<const std::vector<double>> points, std::span<double> costs)>;

struct Progress {
  std::string stage;       ///< the optimiser's title
  double done = 0.0;       ///< 0 .. 1
  double best_cost = 0.0;  ///< so far
  long evaluations = 0;    ///< so far
};

/// How a run is watched, stopped and resumed. All of it is optional.
struct RunControl {
  std::function<void(const Progress&)> progress;  ///< called after every generation, in the caller's thread
  const std::atomic<bool>* stop = nullptr;        ///< looked at before every generation
  std::filesystem::path checkpoint;               ///< written after every generation, resumed from if it exists
  bool writes = true;                             ///< false: another process (rank) writes the checkpoint
  std::string problem;                            ///< fingerprint of what the cost means (scenario, data, engine):
                                                  ///< a checkpoint with another one is refused

  /// For what is fitted within a search: neither told of nor kept.
  RunControl quiet() const;
};

/// One generation, after its evaluation. Median and mean are over the individuals that did not fail.
struct GenerationRecord {
  double best = 0.0;       ///< lowest cost so far
  double median = 0.0;     ///< of this generation; infinity when all failed
  double mean = 0.0;       ///< of this generation; infinity when all failed
  double diversity = 0.0;  ///< see diversity()
  long evaluations = 0;    ///< since the start of the run
  double seconds = 0.0;    ///< since the start of the run, time between resumes left out
};

struct OptimizerResult {
  std::vector<double> best;  ///< empty if stopped before the first generation
  double best_cost = 0.0;    ///< infinity if every evaluation failed
  long evaluations = 0;
  std::vector<GenerationRecord> history;
  bool interrupted = false;  ///< stopped early; the checkpoint, if any, is kept
};

/// Mean over the parameters of the points' standard deviation, in units of a uniform population's (width / sqrt 12):
/// about 1 for a random population, 0 when all points are alike.
double diversity(std::span<const std::vector<double>> points, const Box& box);

/// The record of a generation that was just evaluated.
GenerationRecord record_generation(std::span<const std::vector<double>> points, std::span<const double> costs,
                                   const Box& box, double best_so_far, long evaluations, double seconds);

/// Calls `cost` and turns every failure (NaN or infinity of either sign) into +infinity.
std::vector<double> evaluate(const BatchCost& cost, std::span<const std::vector<double>> points);

}  // namespace lacuna
