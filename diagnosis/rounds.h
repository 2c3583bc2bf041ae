// The search for what is missing, one effect a round, each with the earlier ones in the model.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/diagnosis.h"

namespace lacuna {

using Report = std::function<void(const std::string& stage, double done)>;

class Rounds {
 public:
  /// From `before`, the plain model as identified at the context's step. Findings, candidates and notes go to `out`,
  /// whose `before` and `missing` are filled in already. All of these must outlive it.
  Rounds(const Scenario& scenario, const FitContext& context, DiagnosisCheckpoint& saved, const CurrentModel& before,
         Diagnosis& out, const Report& report);

  /// Rounds until one finds nothing, nothing is left, or there are as many findings as most_effects(). A round that a
  /// checkpoint holds is taken from there.
  void run();
  /// Several findings once more: each beside the others (exchange.h), then each that a later one contains. After any
  /// change, rounds go on. At last what is not needed is taken out (prune.h), and all that stand then are judged anew
  /// (anew.h).
  void reconsider();

  CurrentModel current;
  FitContext context;  ///< with the step that the present model needs
  StepChoice step;

 private:
  bool round();
  bool exchange_findings();
  bool find_anew();
  int most_effects() const;  ///< findings at most: four, or two a joint if those are more

  const Scenario& scenario_;
  DiagnosisCheckpoint& saved_;
  const CurrentModel& plain_;
  Diagnosis& out_;
  const Report& report_;
  int done_ = 0;  ///< rounds
};

}  // namespace lacuna
