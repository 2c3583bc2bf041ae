// Hypotheses about one fitted model, weighed against each other without a further simulation.
//
// Near a fit the whitened residual is linear in every number and in every effect that is put in or taken out:
//   W r(delta, gamma) = W (r + sum of offsets of what was toggled + J_gamma delta).
// The evidence of a set gamma of effects is Laplace's, exact here since all is linear and Gaussian:
//   log m(gamma) = -1/2 min_delta (|W r|^2 + |(x + delta - center)/s|^2) - 1/2 log|I + S^1/2 J' W'W J S^1/2|
//                  + log prior(gamma),   prior(gamma) = h^k (1 - h) / (number of sets of k effects).
// All it needs of the data are inner products of columns, kept block by block in time, so that blocks can be drawn
// again (block bagging: J. H. Huggins, J. W. Miller, Reproducible model selection using bagged posteriors, Bayesian
// Analysis 2023).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ga/problem.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// log of n over k, of k out of n.
double log_choose(double n, double k);

/// log prior of k effects out of n that are offered, before any data: each one more is .3 as probable.
double log_prior_of_effects(double k, double n);

/// A number that a hypothesis is free in: its column and its prior, both in the search coordinate.
struct LinearColumn {
  Eigen::VectorXd train, validate;                ///< whitened sensitivities
  double from_center = 0.0;                       ///< where it stands, from the centre of its prior
  double prior = HUGE_VAL;                        ///< standard deviation
  double lowest = -HUGE_VAL, highest = HUGE_VAL;  ///< room of its step
};

/// What a hypothesis may hold or not.
struct Part {
  EffectSpec spec;
  bool present = false;                    ///< in the model that everything is linear about
  double choices = 1.0;                    ///< alike beforehand, one of which it is (which recordings it acts in)
  int needs = -1;                          ///< the part without which this one says nothing (its effect); -1: none
  Eigen::VectorXd train, validate;         ///< whitened change of the residual when it is toggled
  std::vector<LinearColumn> columns;       ///< of its own numbers
  std::vector<std::vector<double>> start;  ///< own search coordinates of an absent one, to start a fit from
};

/// How often each of `blocks` is drawn, with replacement, in each of `draws` resamples.
std::vector<std::vector<double>> block_draws(std::size_t blocks, int draws, std::uint64_t seed);

class Linearised {
 public:
  /// `blocks`: whose samples stay together when data are drawn again, one number a row of `train`.
  Linearised(Eigen::VectorXd train, Eigen::VectorXd validate, std::vector<LinearColumn> plain, std::vector<Part> parts,
             const std::vector<int>& blocks);

  using Set = std::vector<char>;  ///< one a part

  const std::vector<Part>& parts() const { return parts_; }
  std::size_t blocks() const { return block_grams_.size(); }
  Set present() const;
  Set toggled(Set set, int part) const;

  /// Log evidence; minus infinity for a set that cannot be. A number that would leave its range is held at its end.
  double evidence(const Set& set) const;
  /// The same with each block's data counted `weights` times.
  double evidence(const Set& set, const std::vector<double>& weights) const;

  /// Log-likelihood on the validate rows at the numbers that the train rows give, over that of no model at all.
  double heldout(const Set& set) const;
  /// The same, part by part of the rows, each `length` long.
  std::vector<double> heldout_blocks(const Set& set, Eigen::Index length) const;
  Eigen::VectorXd heldout_rest(const Set& set) const;  ///< the whitened validate rows themselves; empty: impossible
  double train_energy(const Set& set) const;           ///< whitened, at those numbers

  /// Mean over `draws` of the shares of exp(evidence) among `sets`, blocks drawn with replacement.
  std::vector<double> bagged(const std::vector<Set>& sets, int draws, std::uint64_t seed) const;
  /// Share of those draws in which the first of `sets` has most evidence.
  double leads(const std::vector<Set>& sets, int draws, std::uint64_t seed) const;

 private:
  struct Solved {
    bool possible = false;
    double evidence = 0.0, energy = 0.0;
    std::vector<Eigen::Index> columns;  ///< free ones
    Eigen::VectorXd step;               ///< factors of all columns whose sum is the residual
  };
  Solved solve(const Set& set, const Eigen::MatrixXd& gram, double samples) const;
  Eigen::MatrixXd weighed(const std::vector<double>& weights) const;
  std::vector<std::vector<double>> shares(const std::vector<Set>& sets, int draws, std::uint64_t seed) const;
  double log_prior(const Set& set) const;

  std::vector<Part> parts_;
  std::vector<const LinearColumn*> columns_;  ///< all, in the order of the matrices below
  std::vector<LinearColumn> plain_;
  std::vector<Eigen::Index> first_column_;  ///< of each part's own
  Eigen::Index plain_count_ = 0,
               offsets_ = 0;  ///< columns: residual, plain, own of all parts, then offsets of all parts
  Eigen::MatrixXd validate_;  ///< rows x columns
  Eigen::MatrixXd gram_;
  std::vector<Eigen::MatrixXd> block_grams_;
  double samples_ = 0.0;
};

}  // namespace lacuna
