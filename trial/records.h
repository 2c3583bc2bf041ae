// The two records that a blind test holds against each other: what was hidden (`label.json`), and what was said of it
// (`diagnosis.json`), each as far as scoring needs it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ga/identify.h"
#include "physics/outside.h"
#include "trial/laws.h"

namespace lacuna {

/// `label.json`: what was hidden.
struct BlindLabel {
  struct Effect {
    std::string effect, place;
    double strength = 0.0;
    std::optional<LawRecord> law = {};  ///< outside the catalogue only; labels of earlier versions have none
  };
  std::vector<Effect> effects;
  double left_rms_over_noise = 0.0;  ///< what a plain refit leaves; NaN where the label does not say
  /// What else was unlike any model, or how short and lopsided its recordings are, by name (imperfections.h), and how
  /// much, where that is a number.
  std::map<std::string, double> conditions = {};
  bool has(const std::string& condition) const { return conditions.contains(condition); }
  /// Whether no model of the catalogue describes the machine to the end, whatever is hidden.
  bool inexact() const { return has("background") || has("uneven") || has("drift") || has("misplaced"); }
};
/// Throws InputError naming `shown` for text that is no label. Unknown keys are passed over.
BlindLabel read_label(std::string_view json, const std::string& shown);

/// What scoring needs of a `diagnosis.json`.
struct BlindVerdict {
  struct Claim {
    std::string effect, place;
    double probability = 0.0;
    std::vector<std::string> members;  ///< the class
  };
  struct Tried {
    std::string effect, place;
    double train_gain = 0.0;
    int parameters = 0;
  };
  std::string verdict;
  std::vector<Claim> claims;  ///< in the diagnosis' order
  std::vector<LearnedRecord> learned;
  std::vector<Tried> first_round;        ///< everything that was tried on the plain model
  JointRms noise, train, before, after;  ///< train: plain model on train; before, after: on test, else validate
  JointRms validate;                     ///< after, on validate
  double effective_samples = 0.0, seconds = 0.0;
};
/// Throws InputError likewise.
BlindVerdict read_verdict(std::string_view json, const std::string& shown);

}  // namespace lacuna
