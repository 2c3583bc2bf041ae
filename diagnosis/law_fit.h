// Laws that may be missing: which there could be, and each fitted in full simulation.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/hypothesis.h"
#include "diagnosis/law_columns.h"
#include "diagnosis/learnable.h"

namespace lacuna {

constexpr int kRefitSteps = 5;  ///< of the plain parameters beside a curve on its way

/// A law and the set of effects that it is part of, fitted.
struct FittedLaw {
  Learnable law;
  Hypothesis set;
  FittedLaw(Learnable l, Hypothesis h) : law(std::move(l)), set(std::move(h)) {}
};

class LawFit {
 public:
  /// All must outlive it. `standing`: the set that stands at the time of each call, beside which laws are sought.
  LawFit(const Experiment& experiment, const Hypotheses& sets, const Hypothesis& standing)
      : experiment_(experiment), sets_(sets), standing_(standing) {}

  /// Of every law at `joints` that may be learned, the curve of most evidence; most first. Before the law is in, its
  /// own trace is all colour of the rest and the evidence says little: it ranks, nothing more.
  std::vector<Learnable> offer(const std::vector<int>& joints) const;

  /// The law and the parameters beside it in full simulation: the curve is learned again about the motion with it until
  /// it stands, on at most `finest` knots; a step that leaves more is halved. Nothing where it cannot be.
  std::optional<FittedLaw> fitted(const Learnable& start, const Hypothesis& base, int finest = kMostKnots) const;

  /// A curve that repeats itself says more with less: it stands where it predicts the validate recordings as well. What
  /// repeats itself after one period does so after two and three: of those that are not told apart it is the shortest.
  void look_for_a_period(FittedLaw& smooth) const;

  /// Energy on the train recordings over the noise, in the unit of the standing set's weights whatever the fit's own.
  double left_by(const Hypothesis& one) const;

  const std::string& name_of(const Learnable& law) const { return experiment_.joint_names[law.joint]; }
  NamedPlace place_of_law(const Learnable& law) const { return {learned_effect(law.stage), name_of(law)}; }

 private:
  struct About;
  /// A law of given variables, and the knots of the first one that are tried.
  struct Family {
    Learnable law;
    std::span<const int> resolutions;
  };

  std::vector<Family> families(const LawColumns& along, int joint) const;
  Eigen::MatrixXd sensitivities(const About& about, const Learnable& law) const;
  Eigen::VectorXd rest_without(const About& about, const Learnable* stands) const;
  static CurveData data_of(const About& about, const Eigen::MatrixXd& G, const Eigen::VectorXd& without);
  void bend(const About& about, const Learnable* stands, Learnable& law) const;
  bool refine(const About& about, const Learnable& stands, Learnable& law) const;
  std::optional<Hypothesis> with(const Learnable& law, const Hypothesis& base) const;
  double effective_samples(const CurrentModel& now) const;

  const Experiment& experiment_;
  const Hypotheses& sets_;
  const Hypothesis& standing_;
};

}  // namespace lacuna
