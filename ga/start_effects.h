// Starts of simulations are estimated from noisy readings. What their errors do to the predictions looks like a
// mismatch, decays with the motion, and differs from segment to segment; it must not be taken for physics.
//
// Pressures that drive joints are noisy, too: what they push too much or too little over a segment adds up, and is
// carried along as the first few Legendre polynomials of time of which white noise is made.
//
// To first order the prediction of a segment is off by A z, one column of A for each uncertain start coordinate or
// polynomial, z standard normal: random effects (Laird and Ware, Biometrics 38, 1982). The residual's covariance is W^2
// + A A^T with W the weights, and residuals are whitened by it: what the starts explain counts only as far as it
// exceeds their errors.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/plant_model.h"
#include "physics/simulator.h"

namespace lacuna {

/// The columns of A that matter. Rows: the segment's residuals channel by channel, missing samples left out; channel
/// units for one standard error.
struct StartEffects {
  Eigen::MatrixXd columns;
};

/// Fills the segments' start_effects, at `values` of the model's parameters; null stay those whose start does less than
/// a single parameter's worth, all where the prediction is inverse dynamics. Returns whether any start matters.
/// Simulates every segment once for each position, each speed and each chamber's pressure at its start, and for each
/// polynomial of a pressure that drives a joint.
bool attach_start_effects(Experiment& experiment, const PlantModel& model, const SimulatorOptions& options,
                          std::span<const double> values);

/// (W^2 + A A^T)^(-1/2) W as an operator on residuals that are divided by their weights already.
class StartWhitening {
 public:
  StartWhitening() = default;
  /// `row_weights`: of each row of `effects`, which must outlive it. Throws std::invalid_argument where their numbers
  /// differ.
  StartWhitening(const Eigen::MatrixXd& effects, Eigen::VectorXd row_weights);
  void apply(Eigen::Ref<Eigen::VectorXd> residual) const;
  /// The inverse of apply().
  void undo(Eigen::Ref<Eigen::VectorXd> whitened) const;

 private:
  const Eigen::MatrixXd* effects_ = nullptr;
  Eigen::VectorXd inverse_weights_;
  Eigen::MatrixXd shrinkage_, growth_;
};

}  // namespace lacuna
