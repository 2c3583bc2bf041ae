// A search problem: parameters in, whitened residuals out, many at once.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "ga/fitness.h"
#include "ga/search_space.h"
#include "ga/start_effects.h"
#include "physics/simulator.h"

namespace lacuna {

/// One sample of the stacked residual: where it came from.
struct ResidualBlock {
  int segment = 0, channel = 0;
  Eigen::Index first = 0, count = 0;  ///< rows in the stacked residual
};

/// Whitened residuals (predicted - measured) / weight of chosen segments, stacked segment by segment, channel by
/// channel, missing samples left out; whitened by the errors of their starts, too, where the experiment has those.
/// Model, experiment and space must outlive it.
class Problem {
 public:
  /// `weights`: one rms per channel of the prediction, channel units.
  Problem(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
          const SimulatorOptions& options, std::vector<double> weights);

  const PlantModel& model() const { return model_; }
  const Experiment& experiment() const { return experiment_; }
  const SearchSpace& space() const { return space_; }
  const std::vector<double>& weights() const { return weights_; }
  Simulator& simulator() { return *simulator_; }
  const SimulatorOptions& options() const { return options_; }

  /// One column per full parameter vector (not search point).
  std::vector<Eigen::VectorXd> residuals_of(std::span<const std::vector<double>> values, std::span<const int> segments);
  /// The same, the starts taken as exact.
  std::vector<Eigen::VectorXd> plain_residuals_of(std::span<const std::vector<double>> values,
                                                  std::span<const int> segments);
  /// The same of search points.
  std::vector<Eigen::VectorXd> residuals(std::span<const std::vector<double>> points, std::span<const int> segments);
  Eigen::VectorXd residual(const std::vector<double>& point, std::span<const int> segments);

  /// d residual / d point by forward differences, all columns in one batch; `at` = residual(point). Coordinates of
  /// joints that cannot change each other's predictions (branches of the tree on a base that stands still; where the
  /// motion is measured, each joint's own drive and friction) share a simulation: Curtis, Powell and Reid 1974.
  /// Simulated at the longest step at which a sensitivity is right to 2 % in every channel (sensitivity_step):
  /// differences of a residual need no step as fine as the residual does.
  Eigen::MatrixXd jacobian(const std::vector<double>& point, const Eigen::VectorXd& at, std::span<const int> segments);

  /// What changes of the predictions make of the residual, `change(segment, channel)`: at every sample, channel units.
  Eigen::VectorXd residual_change(std::span<const int> segments,
                                  const std::function<Eigen::VectorXd(std::size_t, std::size_t)>& change) const;

  /// Residual or Jacobian rows of `segments`, whitened by `before` (the same but for its weights), whitened by this
  /// one.
  Eigen::MatrixXd reweighed(Eigen::MatrixXd rows, const Problem& before, std::span<const int> segments) const;

  /// The same simulated at another step, s.
  Problem at_step(double step) const;

  /// Layout of the stacked residual.
  std::vector<ResidualBlock> layout(std::span<const int> segments) const;

  /// Costs of search points under one of the paper's fitness functions (errors whitened), nothing stored.
  void costs(std::span<const std::vector<double>> points, std::span<double> out, std::span<const int> segments,
             Fitness fitness);

 private:
  void whiten_starts();
  /// The present step, doubled as often as the sensitivity along one direction through all coordinates stays the same,
  /// s.
  double sensitivity_step(const std::vector<double>& point, const Eigen::VectorXd& at, std::span<const int> segments);
  Eigen::MatrixXd differences(const std::vector<double>& point, const Eigen::VectorXd& at,
                              std::span<const int> segments);

  const PlantModel& model_;
  const Experiment& experiment_;
  const SearchSpace& space_;
  SimulatorOptions options_;
  std::vector<double> weights_;
  std::unique_ptr<Simulator> simulator_;
  std::vector<StartWhitening> starts_;  ///< by segment; none where all starts are exact
};

/// Whether channel c is the one that its joint's figures are about: its position or, in inverse dynamics, its effort.
bool is_leading(const Experiment& experiment, std::size_t c);

/// rms per channel to weigh residuals by: the noise where it is stated or estimated, else the channel's own size.
std::vector<double> first_weights(const PlantModel& model, const Experiment& experiment);

}  // namespace lacuna
