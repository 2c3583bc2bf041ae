// The population call: many simulations of one experiment with different parameters.
//
// Whoever searches (GA, least squares, screening) asks here. On Featherstone the parameter vectors run as SIMD lanes
// times threads; on any other engine one by one over threads. With ranks, each simulates its share. Same answer for any
// number of threads and ranks.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "physics/executor.h"
#include "physics/experiment.h"
#include "physics/linear_motion.h"
#include "physics/plant_model.h"

namespace lacuna {

/// One prediction: parameter vector `individual` on segment `segment`. `predicted[channel][sample]`.
/// For inverse dynamics the channels are the commanded joints, predicted is the command that the model needs for the
/// measured motion less the command given, filtered and thinned to twice the cutoff (channel units: V).
using PredictionVisitor =
    std::function<void(int individual, int segment, const std::vector<std::vector<double>>& predicted)>;

/// Memory, plain bytes, into which the visitor of a pair writes all that is wanted of it.
using PairResult = std::function<std::span<std::byte>(int individual, int segment)>;

struct SimulatorOptions {
  std::string engine = "featherstone";
  int threads = 1;
  double max_step = 0.005;  ///< s; see choose_step()
  const StopFlag* stop = nullptr;
  Ranks* ranks = nullptr;  ///< who shares the simulations; null: this process makes all of them
};

/// A predictor of one plant on one experiment. Stateless between calls; model and experiment must outlive it.
class Simulator {
 public:
  virtual ~Simulator() = default;

  /// Calls `visit` once for every pair, from worker threads, pairs in any order. A diverged simulation holds NaN or
  /// inf. Every rank makes all simulations itself.
  virtual void run(std::span<const std::vector<double>> individuals, std::span<const int> segments,
                   const PredictionVisitor& visit) = 0;
  /// The same shared among ranks: `visit` is called for a pair on one of them, writes into result(pair) and nowhere
  /// else; on return all results stand there on every rank.
  virtual void run(std::span<const std::vector<double>> individuals, std::span<const int> segments,
                   const PredictionVisitor& visit, const PairResult& result) = 0;
  /// The plant of one parameter vector linearised along its motion on each of `segments`.
  virtual std::vector<LinearMotion> linearise(const std::vector<double>& values, std::span<const int> segments,
                                              const std::vector<double>& effort_sizes) = 0;
  /// Calls `visit` once for every pair, from worker threads, with [joint][interval]: what drives each joint beyond what
  /// the motion of that segment (`motions`, one each) needs, N m (N).
  virtual void excess(std::span<const std::vector<double>> individuals, std::span<const int> segments,
                      std::span<const LinearMotion> motions, const PredictionVisitor& visit) = 0;
  /// How many parameter vectors share one pass: batches that are multiples of this waste nothing.
  virtual int lanes() const = 0;
};

/// Throws WorkError where the engine is not available.
std::unique_ptr<Simulator> make_simulator(const PlantModel& model, const Experiment& experiment,
                                          const SimulatorOptions& options);

/// Name of the widest instruction set that the lanes use on this machine ("avx512", "avx2", "sse2") and its width.
struct LaneInfo {
  std::string name;
  int width;
};
LaneInfo lane_info();

/// Error of a fourth-order method at a step over its change when the step is halved (Richardson).
inline constexpr double kErrorOverChange = 16.0 / 15.0;

/// Largest error, as a share of each channel's noise, that the step leaves in the predictions of `values`.
struct StepChoice {
  double step = 0.0;              ///< s
  double error_over_noise = 0.0;  ///< measured by halving
};
inline constexpr double kShortestStep = 1e-4;  ///< s: none is tried below it
/// Halves the step from 10 ms, or the sampling period where that is shorter, until the error stays under a tenth of the
/// noise on every recording; then the longest whole part of it in between that does. Where no step down to
/// kShortestStep reaches that, the longest that does about as well as the best: what diverges or forgets its start at
/// any step is not worth the shortest. No measured value is looked at but the starts.
StepChoice choose_step(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options,
                       std::span<const double> values);

}  // namespace lacuna
