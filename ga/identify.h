// Identification: a search over a plant's free parameters on the train recordings, and what its answer is worth.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ga/genetic_algorithm.h"
#include "ga/least_squares.h"

namespace lacuna {

enum class Optimizer { ga, cmaes, de, lsq, ga_lsq };
const char* to_string(Optimizer optimizer);
/// Throws InputError naming the known ones.
Optimizer optimizer_from_name(const std::string& name);

struct IdentifyOptions {
  Optimizer optimizer = Optimizer::ga_lsq;
  Fitness fitness = Fitness::norm_2;
  GeneticOptions genetic;      ///< population, generations, codings, operators, seed
  SimulatorOptions simulator;  ///< engine, threads; max_step is chosen unless `step` is given
  std::optional<double> step;  ///< s
  /// Least squares stops where a step gains less than this share of the cost: the caller follows the best of several.
  std::optional<double> tolerance;
  /// Least squares once more from its end with what the errors of the measured starts can do to the predictions taken
  /// off (start_effects.h): parameters do not take that up, and their intervals hold it.
  bool start_errors = false;
  RunControl control;
};

/// One parameter of the answer.
struct Estimate {
  std::string name, unit;
  double value = 0.0;
  double lower95 = 0.0, upper95 = 0.0;  ///< cut to the physical range
  bool identifiable = false;            ///< its standard error is under half its size
  bool at_bound = false;
  bool derived = false;      ///< follows from the total mass
  bool spans_range = false;  ///< the interval, before it was cut, covers all that was searched: nothing is known of it
};

/// Residual rms per joint in channel units (positions; efforts in command units for inverse dynamics).
using JointRms = std::vector<std::pair<std::string, double>>;
/// Value of an entry; NaN where it is absent.
double entry_of(const JointRms& rms, const std::string& joint);
/// Root mean square over the joints of rms / noise; NaN where no joint has both.
double over_noise(const JointRms& rms, const JointRms& noise);

struct FitResult {
  std::string engine, optimizer;
  std::vector<double> values;  ///< full parameter vector of the plant
  std::vector<double> point;   ///< search point
  std::vector<Estimate> estimates;
  Identifiability identifiability;
  std::vector<std::string> undetermined;  ///< combinations that the data cannot tell apart, in words
  LeastSquaresResult solution;
  double effective_samples = 0.0;
  std::vector<std::pair<Role, JointRms>> rms;
  std::vector<GenerationRecord> history;  ///< of the population search
  double search_cost = 0.0;               ///< fitness cost after the population search
  StepChoice step;
  bool arrived = true;  ///< false: `doubt` says why the best may not have been reached
  std::string doubt;    ///< "starts disagree: ...", "gradient along a bound: ..."
  long evaluations = 0;
  double seconds = 0.0;
};

/// Search (population search, then least squares, as the optimiser says) on the train segments. Least squares begins at
/// the best of the population search, or at the scenario's start, and at other places (from_several_starts) while the
/// residual is not down to the noise and no two of them meet; the best wins.
/// Throws Interrupted with the checkpoint kept, WorkError when nothing converges.
FitResult identify(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                   const IdentifyOptions& options);

/// By how much of its standard error as reported (or of 1e-5 of its size, where that is more), at most, the
/// integration error moves a coordinate of a solution found in `problem` over `segments`: what halving the step changes
/// in the residual (Richardson), sent through the fit's own sensitivities. A tenth of the noise in the predictions may
/// be several standard errors of a combination that the recordings hardly determine.
double shift_by_integration(Problem& problem, std::span<const int> segments, const LeastSquaresResult& solution);

/// Estimates with 95 % intervals, identifiability, and the combinations in words, from a least-squares solution over
/// `segments`.
void describe_fit(const PlantModel& model, const SearchSpace& space, Problem& problem, std::span<const int> segments,
                  FitResult& fit);

/// "0.81 joint_2.gain + 0.57 joint_2.damping": the members of a unit vector over named coordinates that matter.
std::string combination_in_words(const std::vector<double>& weights, const std::vector<std::string>& names);

/// How a channel's rms is named: by its joint, "joint_2.velocity" where it is not the position or the command.
std::string rms_entry(const Channel& channel, const Experiment& experiment);

/// rms of the residual per joint over the segments of one role.
JointRms residual_rms(Problem& problem, std::span<const double> values, Role role);
/// The same of a residual over those segments, as the problem weights it.
JointRms rms_by_channel(const Problem& problem, const Eigen::VectorXd& residual, std::span<const int> segments);

}  // namespace lacuna
