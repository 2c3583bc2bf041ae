// Sets of effects with places, each fitted, and what one set has over another: the one scale on which all are weighed.
//
// The log evidence of a set is Laplace's about its own fit (linearised.h), the residual and its sensitivities whitened
// with one covariance for all rivals (colour.h). Held-out recordings speak beside it, in the same whitened unit.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/colour.h"
#include "diagnosis/linearised.h"
#include "ga/identify.h"

namespace lacuna {

using NamedPlace = std::pair<std::string, std::string>;  ///< effect, where it stands
NamedPlace place_of(const EffectSpec& spec);

/// The catalogue's entry.
const EffectInfo& effect_info(const std::string& effect);

struct Hypothesis {
  std::vector<EffectSpec> effects;  ///< beyond the plain model's and those of every set, in the order of the model
  CurrentModel model;
};

/// Axes of an effect of the model: their indices.
std::vector<std::size_t> own_axes(const CurrentModel& current, const EffectSpec& spec);

/// Where they stand.
std::vector<double> own_point(const CurrentModel& current, const EffectSpec& spec);

/// What is changed of a set.
struct SetChange {
  std::vector<EffectSpec> in;                             ///< put in
  std::vector<std::vector<double>> own;                   ///< where their own coordinates start
  std::vector<NamedPlace> out;                            ///< taken out
  std::vector<std::pair<NamedPlace, EffectSpec>> shaped;  ///< an effect and its spec with more numbers free
  std::vector<std::vector<double>> shapes;                ///< where those of the new spec start
};

/// Residual and sensitivities of a fitted set, all its numbers alike.
struct FittedRows {
  std::vector<ResidualBlock> blocks;
  Eigen::VectorXd residual;
  std::vector<LinearColumn> columns;
};

/// Log-likelihood that one set gains over another on recordings that neither was fitted to.
struct HeldoutDifference {
  double gain = 0.0;
  double error = 0.0;  ///< standard error, from blocks of the recordings
  double share = 0.0;  ///< of the other's whitened energy that the one takes away
  /// By more than such recordings scatter.
  bool speaks_for() const { return gain > 2.0 * error && gain > 0.0; }
  bool speaks_against() const { return gain < -2.0 * error; }
};

class Hypotheses {
 public:
  /// `plain` must outlive it. `everywhere`: effects that belong to every set and are no member of any.
  Hypotheses(const CurrentModel& plain, const FitContext& context, std::vector<EffectSpec> everywhere = {});

  const FitContext& context() const { return context_; }
  const CurrentModel& plain() const { return plain_; }
  void set_step(double step) { context_.simulator.max_step = step; }
  const std::vector<int>& train() const { return train_; }
  const std::vector<int>& validate() const { return validate_; }

  /// The plain model with what belongs to every set, at neutral; fitted.
  Hypothesis none(int iterations) const;
  /// Least squares with priors, weights brought up to date until a colour is settled on. False: cannot be simulated.
  bool fit(CurrentModel& model, int iterations) const;
  /// A set with a change, from its values, fitted; nothing where it cannot be simulated.
  std::optional<Hypothesis> changed(const Hypothesis& from, const SetChange& change, int iterations) const;

  /// Noise and discrepancy of what a set leaves; once settled, that one for every set.
  Colour colour(const CurrentModel& model, const Eigen::VectorXd& residual,
                std::span<const ResidualBlock> blocks) const;
  void settle(const Hypothesis& on);
  bool settled() const { return settled_.has_value(); }

  /// Of a fitted model at the present step, in other weights.
  FittedRows rows(const CurrentModel& model, std::span<const double> weights) const;
  /// Whitened rows of `of` on the validate recordings, with the colour and in the weights of `by`.
  Eigen::VectorXd heldout_rows(const Hypothesis& of, const Hypothesis& by) const;

  /// Log evidence of one fitted set over another, in the weights and with the colour of the one that leaves less.
  double log_odds(const Hypothesis& one, const Hypothesis& other) const;
  /// What one set gains over another on the validate recordings, on all channels or on those of one joint; nothing
  /// where there are none.
  HeldoutDifference heldout_difference(const Hypothesis& one, const Hypothesis& other,
                                       std::optional<int> joint = {}) const;
  /// log prior of a set, up to what all sets share.
  double log_prior(const std::vector<EffectSpec>& effects) const;
  /// Sets of train recordings that an effect in some of them could have been in.
  double choices_of(const EffectSpec& spec) const;

  /// Whether no number of an effect was driven to the end of its range, where it is no law of a machine (a friction
  /// that grows towards rest beside no sliding friction at all), or too small to be what its name says. Optional
  /// shapes may stand there.
  bool ends_within(const Hypothesis& h, const EffectSpec& spec) const;
  /// Whether one of its strengths is off neutral by more than two standard errors (or none is free); of what joints
  /// share, two joints' parts in it.
  bool is_determined(const Hypothesis& h, const EffectSpec& spec) const;

  /// Effects and places that the catalogue offers beside the plain model.
  std::size_t offered() const { return offered_; }

 private:
  std::vector<double> independent_weights(const CurrentModel& model) const;
  /// Of the validate recordings' stacked residual, the rows of a joint's channels.
  std::vector<Eigen::Index> heldout_rows_of(const CurrentModel& model, int joint) const;
  const Hypothesis& leaves_less(const Hypothesis& one, const Hypothesis& other) const;
  static double evidence_of(FittedRows rows, const Colour& colour);

  const CurrentModel& plain_;
  FitContext context_;
  std::vector<EffectSpec> everywhere_;
  std::vector<int> train_, validate_;
  std::optional<Colour> settled_;
  std::vector<double> settled_weights_;  ///< in which it is
  std::size_t offered_ = 0;
};

/// A search coordinate with its sensitivity.
LinearColumn column_of(const Axis& axis, double x, Eigen::VectorXd train, Eigen::VectorXd validate = {});

}  // namespace lacuna
