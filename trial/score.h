// Blind scoring: verdicts that were given without the labels, held against the labels.
//
// What counts as right is stated here once:
//  - nothing was hidden: the verdict is `consistent`;
//  - physics outside the catalogue was hidden (alone or beside others): the verdict is `unknown_physics`; what was
//    learned of it is scored apart (laws.h);
//  - else: the verdict is `missing_physics`, every hidden effect is claimed at its place, and nothing else is. A claim
//    covers an effect that is the one named or in its class (effects that the data do not tell apart).
//
// Where the machine is besides unlike any model (BlindLabel::inexact), `unknown_physics` is as right as `consistent` or
// `missing_physics`: something is there that nobody can name. What is claimed must be true all the same: hidden, or of
// the same place and stage as a law that was hidden unevenly or drifting, or, where centres of mass are off, that.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trial/records.h"

namespace lacuna {

enum class Seal { none, intact, broken };
const char* to_string(Seal seal);

struct BlindCase {
  std::string name;
  std::optional<BlindVerdict> verdict;
  std::string error;  ///< why there is no verdict
  std::optional<BlindLabel> label;
  Seal seal = Seal::none;
};

enum class CaseKind { null, single, several, outside };
const char* to_string(CaseKind kind);

struct CaseScore {
  CaseKind kind = CaseKind::null;
  bool correct = false;
  bool location = false, effect = false,
       in_class = false;    ///< of the first claim that is not true besides: place; place and effect; or its class
  double f1 = 0.0;          ///< of claims against hidden effects, by class; true claims beside these do not count
  double gain_share = 0.0;  ///< of the oracle's gain on held-out recordings; NaN where there is none to have
  std::vector<bool> claim_true;
  std::vector<LawScore> laws;  ///< one a hidden effect outside the catalogue, in the label's order
  /// What the diagnosed model leaves on held-out recordings: of hidden events on validate ones, since what happens in a
  /// test recording is explained by nothing else. NaN: not known.
  double rest_over_noise = 0.0;
};
constexpr double kAtNoise = 1.15;  ///< rest over noise up to which everything is explained
/// The case must have a label; without a verdict nothing is right.
CaseScore score_case(const BlindCase& one);

/// Hits out of trials, with the 95 % interval of Clopper and Pearson (Biometrika 26, 1934).
struct Rate {
  int hits = 0, of = 0;
  void add(bool hit) { hits += hit, ++of; }
  double share() const;                    ///< NaN for none
  std::pair<double, double> ci95() const;  ///< [0, 1] for none
};

/// Claims of a probability in [from, to).
struct CalibrationBin {
  double from = 0.0, to = 1.0, probability_sum = 0.0;
  Rate truth;
};
/// Single effects whose left rms over noise is in [from, to).
struct StrengthBin {
  double from = 0.0, to = 0.0;
  Rate location, in_class;
};

/// What was learned of effects hidden outside the catalogue.
struct LawTotals {
  Rate unknown;                      ///< the case's verdict
  Rate place, stage, over;           ///< each with those before it; stage and over where the label says them
  Rate events;                       ///< hidden ones that were found
  Rate at_noise;                     ///< the case's rest is at most kAtNoise
  int curves = 0;                    ///< hidden
  std::vector<double> curve_errors;  ///< of those learned over the right variables
  double median_error() const;       ///< NaN for none
};

/// What simpler methods would have said of the same cases.
struct Baselines {
  double refit_gain_share = 0.0;   ///< parameters only: 0 by definition of the share
  Rate largest_residual_location;  ///< single effects at a joint: where the plain model leaves most over noise
  Rate bic_false_alarms, bic_location, bic_effect;  ///< best Schwarz criterion on the train recordings alone
};

struct BlindTotals {
  int cases = 0, labelled = 0, failed = 0;
  Rate correct, null_false_alarms, location_top1, effect_top1, class_top1, abstained_correctly;
  Rate claims_above_09;  ///< true ones among claims of a probability above 0.9
  double set_f1 = 0.0;   ///< mean over cases of several effects; NaN for none
  int several = 0;
  double heldout_gain_share = 0.0;  ///< mean over cases with catalogue effects; NaN for none
  int shared = 0;
  std::vector<CalibrationBin> calibration;
  std::vector<StrengthBin> strength;
  Baselines baselines;
  LawTotals laws;                            ///< over every hidden effect outside the catalogue
  std::map<std::string, LawTotals> laws_of;  ///< by that effect
  Rate false_laws_null, false_laws_exact;    ///< nothing, catalogue effects alone hidden: something learned
  Rate events_true;                          ///< of those learned where something outside the catalogue was hidden
  double seconds = 0.0, longest = 0.0;       ///< of the diagnoses: sum, longest
  std::map<std::string, std::map<std::string, int>> confusion;  ///< hidden -> said -> cases: nulls, singles, outside
};
BlindTotals total(const std::vector<BlindCase>& cases);

/// Totals of the labelled cases under each condition that some of them have: the label's own, then "everywhere" (one
/// effect hidden at several joints), then "none". A case may stand under several. Empty where there is but
/// "none".
std::vector<std::pair<std::string, BlindTotals>> totals_by_condition(const std::vector<BlindCase>& cases);

}  // namespace lacuna
