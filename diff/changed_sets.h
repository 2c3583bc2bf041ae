// Which of a machine's numbers changed between two sets of recordings: a choice among subsets, by closed-form evidence.
//
// Both sets are quadratic near their fits: -log L_s(y) = 1/2 y'H_s y - h_s'y + const, y the search coordinates counted
// in their priors' standard deviations from the priors' centres. A subset c of groups of coordinates differs, the rest
// is common: y_B = y_A + d_c, with y_A ~ N(m, diag t^2) and d_c ~ N(0, I): a change is as large as a number may be.
// Then
//   log m(c) = 1/2 b'K^-1 b - 1/2 log|K| + log prior(c),  prior(c) = h^k (1 - h) / (N over k),  h = .3,
// K and b being the informations and linear terms of both sets and the priors over (y_A, those of y_B that differ).
// A coordinate that neither set determines has no part in K but its prior and says nothing for or against a change.
// m and t are 0 and 1, or where the quadratics are linearisations the present point and how far they hold: a direction
// that no set determines (all gains, springs and masses by one factor) would else be followed to where it means
// nothing, all numbers 0, which fits any two sets alike. The same evidence over sets of effects:
// diagnosis/linearised.h.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace lacuna {

/// One set of recordings about a fit: -log L(y) = 1/2 y' information y - linear' y, up to a constant.
struct Quadratic {
  Eigen::MatrixXd information;
  Eigen::VectorXd linear;
};

/// Of the common numbers: centre and standard deviation of each.
struct CommonPrior {
  Eigen::VectorXd center, deviation;
};

/// Groups of coordinates that change together (a plain number alone, all numbers of an effect), and which do.
using ChangeGroups = std::vector<std::vector<Eigen::Index>>;
using ChangedSet = std::vector<char>;  ///< one a group

/// Columns of the coordinates of both sets: those of A first, then those of B that differ.
class JointColumns {
 public:
  JointColumns(Eigen::Index size, const ChangeGroups& groups, const ChangedSet& changed);
  Eigen::Index size() const { return columns_; }
  Eigen::Index of_b(Eigen::Index i) const { return b_[i]; }
  bool apart(Eigen::Index i) const { return of_b(i) != i; }

  /// Information of both sets, and of priors that have that of `common` (a diagonal) for the common numbers.
  Eigen::MatrixXd joined(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const Eigen::VectorXd& common) const;
  Eigen::VectorXd joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;

 private:
  Eigen::Index columns_;
  std::vector<Eigen::Index> b_;
};

/// What a subset says of both sets' numbers.
struct ChangePosterior {
  Eigen::VectorXd a, b;              ///< means
  Eigen::VectorXd error_a, error_b;  ///< standard errors
  Eigen::VectorXd covariance_ab;     ///< of the same coordinate in A and B
};

class ChangedSets {
 public:
  /// Every coordinate in at most one group. Throws std::invalid_argument for sizes that do not agree.
  ChangedSets(Quadratic a, Quadratic b, ChangeGroups groups);
  ChangedSets(Quadratic a, Quadratic b, ChangeGroups groups, const CommonPrior& common);

  std::size_t groups() const { return groups_.size(); }
  ChangedSet none() const { return ChangedSet(groups_.size(), 0); }
  /// Up to what all subsets share.
  double evidence(const ChangedSet& changed) const;
  /// Where the informations are those at the subset's own fit, whose cost (joint_fit.h) is known: -1/2 cost in place of
  /// 1/2 b'K^-1 b. Of fits wherever they lie.
  double evidence_of_fit(const ChangedSet& changed, double cost) const;
  ChangePosterior posterior(const ChangedSet& changed) const;

 private:
  using Root = Eigen::LLT<Eigen::MatrixXd>;
  Root root_of(const JointColumns& columns) const;
  /// Of its spread, and of how many change.
  double log_volume(const Root& root, const ChangedSet& changed) const;

  Quadratic a_, b_;
  ChangeGroups groups_;
  Eigen::VectorXd common_, from_center_;  ///< of the common numbers' priors: information, and that times the centre
};

/// A subset that lives, with its share of exp(evidence).
struct LivingSet {
  ChangedSet changed;
  double evidence = 0.0, share = 0.0;
};

/// Forward, backward and by swaps from nothing and from `start`; all subsets within 8 nats of the best live (Occam's
/// window: Madigan and Raftery, JASA 89, 1994). Most probable first.
std::vector<LivingSet> search_changes(const ChangedSets& sets, const std::vector<ChangedSet>& starts = {});

/// That a group changed: the sum over the living sets that hold it. [group]
std::vector<double> change_probabilities(const std::vector<LivingSet>& living);

/// Members of the best set's `group`'s class: it first, then groups that in its place have within 3 nats of its
/// evidence, so that the recordings do not tell which of them changed.
std::vector<std::size_t> change_class(const ChangedSets& sets, const ChangedSet& best, std::size_t group);

/// That at least one of `members` changed.
double class_probability(const std::vector<LivingSet>& living, const std::vector<std::size_t>& members);

}  // namespace lacuna
