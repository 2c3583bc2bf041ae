// One of the two sets of recordings, with the model that both share the structure of.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "diagnosis/candidates.h"
#include "diff/changed_sets.h"

namespace lacuna {

/// What may change: a plain number, or an effect with all its numbers.
struct Changeable {
  std::string name;    ///< "joint_2.gain", "joint_2.coulomb_friction"
  std::string effect;  ///< empty: a plain number
  std::string place;   ///< "joint_2", "arm", "link_3"
  std::string key;     ///< of a plain number: "gain", "mass"
  std::vector<std::size_t> axes;
  std::vector<std::string> look_alikes;  ///< effects that a diagnosis did not tell from this one
  std::vector<std::string> recordings;   ///< files in which it acts; empty: all
};

/// A set of recordings, and the model at a point for it. Axes and priors are the same on both sides.
struct Side {
  Experiment experiment;
  CurrentModel model;  ///< weights: rms of what a channel leaves, times the root of the samples that say one thing
  SimulatorOptions simulator;
  std::vector<std::pair<std::size_t, double>> pins;  ///< axes that are known on this side, and their search coordinate

  const std::vector<Axis>& axes() const { return model.space.axes(); }
  FitContext context() const { return {experiment, simulator}; }
};

/// Residual rows of one role at a point, in the side's weights.
Eigen::VectorXd rows_at(const Side& side, const std::vector<double>& point, Role role);

/// Information of the train recordings about a point, residual and sensitivities there, in units of the priors. Along
/// every eigenvector of it the data count for no more than their scores scatter: from stretch to stretch of time
/// (ga/sandwich.h) and from recording to recording. Where the model is exact that changes nothing; a law that is not
/// quite right, or a number that drifts, is not taken for knowledge.
Quadratic information_about(const Side& side, const std::vector<double>& point, const Eigen::VectorXd& residual,
                            const Eigen::MatrixXd& jacobian);

/// The same at a point that is simulated first.
Quadratic information_at(const Side& side, const std::vector<double>& point);

/// Search coordinates in units of the priors, from their centres.
Eigen::VectorXd in_priors(const Side& side, const std::vector<double>& point);

}  // namespace lacuna
