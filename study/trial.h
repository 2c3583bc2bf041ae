// The identification problem that a study repeats: a scenario made as cheap to simulate as its physics allows, the box
// that optimisers see, what is known of the truth, and the errors of an answer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ga/problem.h"
#include "study/locked.h"

namespace lacuna {

/// What joint data can tell of a single moving joint on a spring: ratios in which the common factor of all efforts and
/// masses cancels. Gravity's moment about the joint is cos q and sin q times a constant each.
struct Combination {
  std::string name;  ///< "gain / stiffness"
  std::string unit;
  double value = 0.0;
};

/// Immutable once made; shared by all threads.
struct Trial {
  std::string name;
  Scenario scenario;               ///< with locked joints fixed
  std::vector<std::string> fixed;  ///< joints that were locked
  std::shared_ptr<const PlantModel> model;
  Experiment experiment;
  std::vector<double> weights;  ///< rms per channel, channel units
  StepChoice step;
  Box box;                    ///< one interval per searched parameter, in the scenario's order; search coordinates
  std::vector<Axis> axes;     ///< of each coordinate of the box; parameter -1: it moves nothing in these recordings
  std::vector<double> start;  ///< the scenario's start values
  std::vector<std::string> units;            ///< of each coordinate's parameter
  std::optional<std::vector<double>> truth;  ///< as a point of the box; absent: nobody knows
  double output_scale = 1.0;                 ///< residual over noise -> output_unit
  std::string output_unit;                   ///< "deg" or "mm" for a single position channel, else "times the noise"
};

/// `truth`: a scenario whose values are the true ones (never used but to score answers). Throws InputError where
/// nothing is searched, no recording has role train, or the truth lacks a parameter or lies outside the bounds.
Trial make_trial(const Scenario& scenario, const Scenario* truth);

/// The scenario file beside the first train recording that holds its truth (`truth.yaml`), if there is one.
std::optional<std::filesystem::path> find_truth(const Scenario& scenario);

/// One set of data and bounds on which searches run. The trial must outlive it.
struct Task {
  const Trial& trial;
  Experiment experiment;
  SearchSpace space;  ///< the coordinates of the box that move anything
  Box box;
  std::vector<double> weights;
  SimulatorOptions simulator;
  std::vector<int> train;
};

/// The trial's own data and bounds, on `engine`. Simulations run in the calling thread.
Task make_task(const Trial& trial, const std::string& engine, const StopFlag* stop);
/// Other data of the same plant; or another box (refused with std::logic_error for a scenario with a known total mass).
Task make_task(const Trial& trial, const Experiment& experiment, const std::optional<Box>& box,
               const std::string& engine, const StopFlag* stop);

/// Point of the box -> point of the task's space, and back with `rest` for coordinates that move nothing.
std::vector<double> inner_point(const Task& task, std::span<const double> point);
std::vector<double> outer_point(const Task& task, std::span<const double> inner, std::span<const double> rest);

/// Full parameter vector of the model at a point of the trial's box.
std::vector<double> model_values(const Trial& trial, std::span<const double> point);
/// Values of the searched parameters (not search coordinates) at a point.
std::vector<double> parameter_values(const Trial& trial, std::span<const double> point);

/// Combinations at a point of the box; empty unless the plant is one revolute joint with torque_source and stiffness.
std::vector<Combination> combinations(const Trial& trial, std::span<const double> point);

/// How wrong an answer is.
struct AnswerErrors {
  double output_largest = 0.0;     ///< infinity norm of the output error over the train recordings, output_unit
  double output_rms = 0.0;         ///< output_unit
  double parameter_index = 0.0;    ///< the paper's: sum of relative errors over all parameters, percent; NaN: no truth
  double combination_index = 0.0;  ///< the same over the combinations; NaN: no truth or no combinations
};
AnswerErrors errors_of(Problem& problem, const Task& task, std::span<const double> point);

}  // namespace lacuna
