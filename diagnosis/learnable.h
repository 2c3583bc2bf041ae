// A law that may be learned, and what the linearised plant says of its curve.
//
// A law is a function of one variable or two by its values at evenly spaced knots (physics/effects/learned_curve.h):
// a Gaussian process of a smooth curve or of one that repeats itself, whose size is set by evidence (C. E. Rasmussen,
// C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, ch. 5).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/catalogue.h"
#include "physics/effects/learned_curve.h"
#include "scenarios/scenario.h"

namespace lacuna {

struct Learnable {
  struct Variable {
    LearnedCurve::Variable over = LearnedCurve::kPosition;
    int of = 0;                   ///< 0: of the joint itself; else a joint's number from 1 on
    double from = 0.0, to = 0.0;  ///< first and last knot
    int knots = 0;
    bool is(const Variable& other) const { return over == other.over && of == other.of; }
    double place(int knot) const { return from + (to - from) * knot / (knots - 1); }
    double spacing() const { return (to - from) / (knots - 1); }
  };

  int joint = 0;
  Stage stage = Stage::link;  ///< of an effort; `command`, `reading`
  Variable over;
  std::optional<Variable> beside;
  std::pair<double, double> seen;  ///< range of the first variable
  double period = 0.0;             ///< over the first variable, all over which the knots are then; 0: none
  Eigen::VectorXd values, errors;  ///< at the knots (the second variable's next to each other), and standard errors
  double evidence = -HUGE_VAL;
  double occam = 0.0;  ///< part of the log evidence that the curve's freedom costs, whatever it explains

  /// A curve that repeats itself, from the start of the range.
  void set_period(double of);
  int size() const { return over.knots * (beside ? beside->knots : 1); }
  /// Whether it is a law of the same joint, stage and variables.
  bool is_alike(const Learnable& other) const;
  /// Whether it is a law of two variables, one of which the other is a law of.
  bool contains(const Learnable& other) const;
  /// Whether the second variable only says which way the joint moves.
  bool has_branches() const { return beside && beside->knots == 2; }
  /// As an effect of a scenario.
  EffectSpec spec(const std::string& joint_name) const;
};

/// "learned_effort", "learned_command" or "learned_reading".
const char* learned_effect(Stage stage);

/// What the data say of a curve: quadratic form and slope of what it leaves, in its values at the knots.
struct CurveData {
  Eigen::MatrixXd square;  ///< G^T G, G the sensitivities with what the fitted parameters take up projected off
  Eigen::VectorXd slope;   ///< -G^T r, r what is left without the curve
  double all = 0.0;        ///< r^T r
  double samples = 0.0, effective = 0.0;  ///< all, and those that say one thing each
};

/// The curve of most evidence, if it has more than the one that `law` has; over no curve at all, the noise level
/// profiled out.
void weigh_curve(const CurveData& data, Learnable& law);
/// Of the law's own period and those within a share of it, as `data` says of each.
void sharpen_period(const std::function<CurveData(const Learnable&)>& data, double share, Learnable& law);
/// By how much of a period neighbours shift over the range that was seen: what the first guess of it is good to.
double period_share(const Learnable& law, double period);
/// The period of most evidence that a curve over the range could have, from a few knots to half of the range.
std::optional<double> period_of(const CurveData& data, const Learnable& law);

}  // namespace lacuna
