// What an excitation can tell of the parameters at all, before any search: rank, standard errors, confidence ellipses.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ga/least_squares.h"
#include "study/trial.h"

namespace lacuna {

/// A 95 % confidence region of two quantities.
struct Ellipse {
  std::string x_name, y_name, x_unit, y_unit;
  double x = 0.0, y = 0.0;                     ///< the centre
  std::vector<double> boundary_x, boundary_y;  ///< closed
};

struct ParameterKnowledge {
  std::string name, unit;
  double value = 0.0;
  double relative_error = 0.0;  ///< expected standard error over the parameter's size
  bool moves = true;            ///< false: it changes nothing in these data
};

struct Excitation {
  std::string name;        ///< "train.csv", "step"
  std::string assumption;  ///< "total mass known" or empty
  int rank = 0, parameters = 0;
  double condition = 0.0;  ///< of the scaled sensitivities; infinite where a parameter moves nothing
  std::vector<ParameterKnowledge> knowledge;
  std::vector<std::string> undetermined;  ///< combinations in words, worst first
  std::vector<Combination> combinations;  ///< with their expected relative errors:
  std::vector<double>
      combination_error;  ///< standard error over value, every coordinate known to bound_deviations() before
  std::vector<Ellipse> ellipses;
};

/// What the bounds alone say of every coordinate: the deviation of a uniform distribution over them.
Eigen::VectorXd bound_deviations(const Trial& trial);

/// Whitened sensitivities at a point of the box: one column per coordinate, zero where it moves nothing.
Eigen::MatrixXd sensitivities(const Task& task, std::span<const double> point);

/// What `task`'s train segments determine at `point`. `total_mass_known`: the sum of the searched masses is known to a
/// gram.
Excitation assess(const Task& task, std::span<const double> point, const std::string& name, bool total_mass_known);

/// Where the plant comes to rest under no command with these values (model's full vector), one position a joint:
/// simulated until nothing moves. Joints whose position is not measured, and plants that do not come to rest, keep the
/// start of the first train segment.
std::vector<double> rest_position(const Trial& trial, std::span<const double> values);

/// A step of every actuated joint after half a second, `volts` per joint.
CommandTrack step_commands(const Trial& trial, std::span<const double> volts, double seconds);

/// Every recording of the scenario and the paper's step (peaks as the recordings'), each with and without a known total
/// mass; at the truth, else at the start values.
std::vector<Excitation> assess_all(const Trial& trial);

/// Parameters that one answer gives, against the truth.
struct Recovered {
  std::string name, unit;
  double truth = 0.0;
  std::vector<double> value, lower95, upper95;  ///< one a run
  std::vector<bool> identifiable;               ///< as the answer itself says
};

/// How often the 95 % intervals of identification (GA, then least squares) hold the truth.
struct RecoveryRecord {
  std::vector<Recovered> parameters;  ///< empty: the part was left out
  int held = 0, asked = 0;            ///< intervals that hold the truth, of parameters called identifiable
};

}  // namespace lacuna
