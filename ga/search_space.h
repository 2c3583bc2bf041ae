// Which numbers of a plant are searched, between which bounds, and how a search point becomes a parameter vector.
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ga/optimizer.h"
#include "physics/experiment.h"
#include "physics/plant_model.h"

namespace lacuna {

/// What a search of the plain model's parameters moves.
enum class Coordinates {
  values,  ///< the parameters themselves between hard bounds: what a study and the seed's optimisers are stated in
  ratios   ///< logarithms of value over start value, with priors: gains, springs and masses share one scale
};

/// One coordinate of the search: value = unit * from_search(coordinate, x). Bounds, start and prior are in x. Only
/// least squares knows the prior: it keeps what the data leave open near `center`, where bounds alone would let it
/// slide.
struct Axis {
  int parameter = 0;  ///< index in PlantModel::parameters()
  double lower = 0.0, upper = 0.0, start = 0.0;
  Coordinate coordinate = Coordinate::linear;
  double prior = HUGE_VAL;  ///< standard deviation of a Gaussian prior about `center`; infinite: none
  double center = 0.0;      ///< of the prior
  double unit = 1.0;        ///< the parameter's unit; of a ratio its start value, sign included

  double value(double x) const { return unit * from_search(coordinate, x); }
  double at(double value) const { return to_search(coordinate, value / unit); }
};

/// A mass that is searched as a ratio while the total is known.
struct SharedMass {
  int parameter = 0;
  int axis = -1;                                 ///< -1: it is the dependent one, against which ratios are counted
  double start = 0.0, lower = 0.0, upper = 0.0;  ///< kg
};

/// Search point -> parameter vector.
///
/// Values: every axis is its parameter (or inverse, or logarithm, as the parameter's kind says). With a known total
/// mass one free link mass (the heaviest at the start) is no axis: it takes what the others leave, within its bounds;
/// beyond them the others are scaled so that the total always holds.
///
/// Ratios: a parameter whose bounds are of one sign is searched as log(value / start). Bounds stay hard, but every axis
/// has a prior about its start, a standard deviation of a quarter of its range: bounds are read as two standard
/// deviations either way, so that a valley which the data leave open ends at the prior's bottom and not at a wall. With
/// a known total mass an axis is the logarithm of its mass over the heaviest one's, counted from the start values; the
/// masses are their shares of the total, which holds exactly, and no mass takes what the others leave. What a mass'
/// bounds refuse is shared out among the others.
class SearchSpace {
 public:
  /// Axes from the scenario's `identify`; throws InputError for names that match nothing, start values outside the
  /// bounds, relative bounds of a zero start value, or a total mass that cannot be met.
  SearchSpace(const PlantModel& model, const Scenario& scenario, Coordinates coordinates = Coordinates::values);

  /// One more axis at the end (an effect's parameter). Bounds are cut to the parameter's physical range.
  void add(const PlantModel& model, const Axis& axis);
  /// Parameters that `model` has beyond those known so far stay at its values.
  void hold(const PlantModel& model);

  /// The same axes with other bounds, starts or priors; std::invalid_argument for others.
  void replace(std::vector<Axis> axes);

  std::size_t size() const { return axes_.size(); }
  const std::vector<Axis>& axes() const { return axes_; }
  Box box(const PlantModel& model) const;
  std::vector<double> start() const;

  /// Full parameter vector of a search point; parameters that are no axis keep their value in the model. One that must
  /// not lie below another (ParameterInfo::at_least) is raised to it.
  std::vector<double> expand(std::span<const double> point) const;
  /// The search point of a parameter vector.
  std::vector<double> contract(std::span<const double> values) const;

  /// The free mass that has no axis of its own where the total is known; its parameter index, or -1.
  int dependent() const { return dependent_; }
  /// Searched masses under a known total, of ratios only.
  const std::vector<SharedMass>& shared_masses() const { return shared_; }

 private:
  void note_orders(const PlantModel& model);
  void constrain_total_mass(const PlantModel& model, const Scenario& scenario);
  void share_total_mass(std::vector<SharedMass> masses, std::size_t heaviest);
  void expand_masses(std::span<const double> point, std::vector<double>& values) const;

  std::vector<Axis> axes_;
  std::vector<double> base_;                                 ///< values of the model
  std::vector<std::pair<std::size_t, std::size_t>> orders_;  ///< parameters of which the first is at least the second
  int dependent_ = -1;
  double dependent_lower_ = 0.0, dependent_upper_ = 0.0;
  double free_mass_ = 0.0;  ///< kg, what the free masses must sum to
  std::vector<std::size_t> mass_axes_;
  std::vector<SharedMass> shared_;
  Coordinates coordinates_ = Coordinates::values;
};

/// kg m^2 (kg): what the joint's efforts (train) could accelerate as fast as it moves. A motor's inertia behind its
/// gear may be many times the link's, and comes near this.
double driven_inertia(const PlantModel& model, const Experiment& experiment, int joint);

/// Value of a typical size, in the unit of a parameter of this scale at `joint` (-1: the arm): what one `start` of an
/// effect's parameter is measured in. Taken from the train recordings and the model's start values.
double typical_size(Scale scale, const PlantModel& model, const Experiment& experiment, int joint,
                    std::span<const double> values);
/// What a typical size is counted from: the middle of the range travelled for `reach`, else zero.
double typical_origin(Scale scale, const Experiment& experiment, int joint);

}  // namespace lacuna
