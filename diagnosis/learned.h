// Where the catalogue has no name: the law itself, learned from what is left.
//
// A rest that no named effect explains is looked for as an effort at every joint that is a smooth function of its
// position or of its speed, through the plant linearised about the present motion (linear_look.h): a Gaussian process
// on evenly spaced knots, its size and its resolution by evidence (C. E. Rasmussen, C. K. I. Williams, Gaussian
// Processes for Machine Learning, 2006, ch. 5). The one of most evidence is put into the plant as a learned effect,
// everything else is fitted again in full simulation, and the curve is learned again about the motion with it (Gauss
// and Newton) until it stands. It stays if the validate recordings are predicted better by more than they scatter. Then
// what is left is looked at again. At last every named effect is taken out and the law learned anew: names that had
// only stood in for the law say nothing beside it, and go.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/diagnosis.h"
#include "diagnosis/hypothesis.h"

namespace lacuna {

/// A named effect that is a simpler one beside the law.
struct SimplerName {
  EffectSpec was, is;       ///< at one place
  std::vector<double> own;  ///< search coordinates where the first stood
  double odds = 0.0;        ///< log evidence of the simpler one over it
};

struct LearnedLaws {
  bool changes_names() const { return !needless.empty() || !simpler.empty(); }
  bool changes_nothing() const { return laws.empty() && !changes_names(); }
  /// What it did to the names, in the order in which `named` has them: needless ones go, and where one is a simpler one
  /// the probability of both is shared out anew.
  void follow(std::vector<Finding>& findings) const;

  CurrentModel model;  ///< the present one with the laws found, fitted
  std::vector<LearnedLaw> laws;
  std::vector<NamedPlace> needless;  ///< named effects that say nothing beside them, and are no part of it any more
  std::vector<SimplerName> simpler;  ///< named effects that are another one in the model
  CurrentModel named;                ///< what is named alone, without the laws
};

/// From `current`, which leaves a rest and has named effects beyond `plain`. Nothing is learned without validate
/// recordings. Where efforts are predicted, laws are sought that act at the link.
LearnedLaws learn_laws(const CurrentModel& plain, const CurrentModel& current, const FitContext& context);

}  // namespace lacuna
