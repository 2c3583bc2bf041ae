// What effects would do to the residual, to first order and without simulating them: from the efforts that they add
// along the present motion, through the plant linearised about it (physics/linear_motion.h). Where the motion is
// measured and efforts are predicted, what an effect adds at a joint is taken off what the joint's drive must give.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "diagnosis/candidates.h"

namespace lacuna {

class LinearLook {
 public:
  /// About the present fit, on `segments`, at the context's step. The model and the recordings must outlive it.
  LinearLook(const CurrentModel& current, const FitContext& context, std::vector<int> segments);

  /// Whether an effect of the catalogue does its work as an effort along the motion: not one that reads the motion, is
  /// late, or lies between the actuator's side and the link. Of none where the present model has such a side, where the
  /// motion is measured and not simulated, or where it cannot be linearised.
  bool applies(const EffectInfo& effect) const;

  /// Whether anything is.
  bool is_linearised() const { return problem_.has_value(); }
  /// Whether the motion is measured, and efforts are predicted: then only what acts at a joint is known here.
  bool is_measured() const { return is_measured_; }

  /// Changes of the whitened residual, one for each full parameter vector of `model`, which is the present one
  /// with further effects.
  std::vector<Eigen::VectorXd> changes(const PlantModel& model, std::span<const std::vector<double>> values) const;

  /// The `at`-th segment's motion, measured or the present one in the middle of its intervals.
  const MeasuredMotion& motion(std::size_t at) const;
  /// Changes of the whitened residual, one a column, under efforts at one joint: [motion], rows the columns' own
  /// efforts at every sample of it, N m (N).
  Eigen::MatrixXd changes_at(int joint, const std::vector<Eigen::MatrixXd>& efforts) const;
  /// Under what a joint's position is read too much: [motion], rows the columns' own at every sample, rad (m).
  Eigen::MatrixXd changes_read(int joint, const std::vector<Eigen::MatrixXd>& slips) const;
  /// The same in the `at`-th of the segments alone, of efforts [column][sample of the motion] and of what a joint's
  /// position is read too much [column][sample], rad (m).
  Eigen::MatrixXd changes_in(std::size_t at, int joint, const Eigen::MatrixXd& efforts) const;
  Eigen::MatrixXd changes_read_in(std::size_t at, int joint, const Eigen::MatrixXd& slips) const;

 private:
  void linearise();
  /// What every channel's prediction changes by where its joint is given an effort of 1 N m (N).
  void probe_efforts();
  /// Efforts needed by the measured motion, filtered and thinned as those that were measured.
  Eigen::MatrixXd changes_of_efforts(std::size_t at, int joint, const Eigen::MatrixXd& efforts) const;
  /// Of all segments, one below the other.
  Eigen::MatrixXd stacked(const std::function<Eigen::MatrixXd(std::size_t at)>& part) const;
  /// Puts changes of the predictions of one segment into a column of `out`, whitened.
  void put(std::size_t at, Eigen::MatrixXd& out, Eigen::Index column, Eigen::Index columns,
           const std::function<Eigen::VectorXd(std::size_t channel)>& change) const;
  /// [segment]: changes of positions and speeds; of the residual.
  Eigen::VectorXd residual_of(const std::vector<Eigen::MatrixXd>& responses) const;

  const CurrentModel& current_;
  const Experiment& experiment_;
  SimulatorOptions simulator_;
  std::vector<int> segments_;
  std::optional<Problem> problem_;      ///< none: nothing is linearised
  std::vector<LinearMotion> motions_;   ///< of these segments
  std::vector<Eigen::MatrixXd> needs_;  ///< [joint][interval], what drives the present model beyond what it needs
  bool is_measured_ = false;
  std::vector<double> per_effort_;  ///< [channel], where the motion is measured: its unit over N m (N)
};

}  // namespace lacuna
