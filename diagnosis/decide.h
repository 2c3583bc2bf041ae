// Steps 3 and 4: which screened effect, if any, is better than chance on recordings that were not fitted.
//
// An effect is kept only if all of these hold:
//  - the chance of its gain under no effect, that on the train recordings and that on the validate recordings together
//    (Fisher), times everything that was tried (Bonferroni), is under 1 in 100;
//  - the validate recordings gain, and go its way by more than two standard errors of what noise would;
//  - where it removes most, it removes at least a quarter of the energy that stands above that joint's noise on the
//    validate recordings (of all energy where the noise is unknown): what explains less is not the explanation, and the
//    rest stays reported as unknown. Joint by joint, since every joint of a machine may miss something of its own;
//  - that change is at least a tenth of the noise, rms over all channels (where the noise is known): integration errors
//  up
//    to that are allowed, and a found effect's law is seldom the machine's to the last digit;
//  - none of its own numbers was driven to the end of its range.
// Among those the one with the most evidence wins: train and validate gain less half its parameters times the logarithm
// of the effective samples (Schwarz). Gains closer to the best than what the integration error can feign count as the
// best's, so that of two indistinguishable explanations the one with fewer numbers wins. Probabilities are shares of
// exp(evidence) among all that pass and chance, which no such tie lifts them over; where chance is more probable than
// all that pass together, none is kept.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/evidence.h"
#include "diagnosis/screen.h"

namespace lacuna {

constexpr double kChance = 0.01;         ///< of a gain, under no effect
constexpr double kStandardErrors = 2.0;  ///< by which held-out recordings must go the way of an effect

constexpr const char* kLessEvidence = "less evidence";  ///< note of a candidate that could have been kept

/// Whether recordings that were not fitted speak for it.
inline bool held_out(const HeldoutGain& g) { return g.gain > 0.0 && g.standard_errors > kStandardErrors; }

struct DecideOptions {
  std::uint64_t seed = 1;
  double choices = 1.0;  ///< in how many ways the places tried could have been chosen: each try counts so often
  double integration_error = 0.0;  ///< rms over the noise's, at the step in use
};

/// A candidate with fewer numbers than the one kept that could stand in the same place: with another effect beside it,
/// it may be the truth that the one kept imitates.
struct Branch {
  Finding finding;
  CurrentModel model;
};

struct Decision {
  std::vector<Candidate> candidates;  ///< everything tried, most evidence first
  std::optional<Finding> finding;     ///< the one kept
  CurrentModel model;                 ///< with it, refitted; the present one if none was kept
  double step = 0.0;                  ///< s, at which that was decided
  std::optional<Branch> branch;       ///< the one with the most evidence, if any
};

Decision decide(const CurrentModel& current, const FitContext& context, std::vector<ScreenedEffect> screened,
                const DecideOptions& options);

}  // namespace lacuna
