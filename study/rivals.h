// What the genetic algorithm is worth: every optimiser on the same problem with the same budget, success against budget
// (data profiles: J. J. More, S. M. Wild, Benchmarking derivative-free optimization algorithms, SIAM J. Optim. 20,
// 2009), and what follows from it.
#pragma once

#include <string>
#include <vector>

#include "study/identifiability.h"
#include "study/runner.h"
#include "study/statistics.h"

namespace lacuna {

/// A run has succeeded once its rms residual is within this factor of the lowest that any run of the study found.
struct Level {
  std::string name;  ///< "as good as the best"
  double factor = 1.01;
};
std::vector<Level> success_levels();

struct MethodRecord {
  SearchMethod method = SearchMethod::ga;
  std::vector<SearchRun> runs;
  /// [level][run]: evaluations at which the level was reached; infinity: never.
  std::vector<std::vector<double>> reached;
  /// [level]: share of the runs that reach it within the budget.
  std::vector<double> success;
};

struct RivalsRecord {
  std::vector<MethodRecord> methods;  ///< empty: the part was left out
  long budget = 0;                    ///< evaluations a run
  double best = 0.0;                  ///< lowest cost of any run
  /// The method recommended at the strict level: most successes, then fewest evaluations to them (median).
  int recommended = -1;
  std::string reason;  ///< why, in one sentence with its figures
};

struct RivalsPlan {
  int seeds = 5;
  std::uint64_t seed = 1;
  int population = 70;
  long evaluations = 14000;
  int round_generations = 20;  ///< see Budget
};

void plan_rivals(const Trial& trial, const RivalsPlan& plan, const StopFlag* stop, StudyRunner& runner);
RivalsRecord summarise_rivals(const Trial& trial, const RivalsPlan& plan, const StudyRunner& runner);

/// One round of SearchMethod::ga_lsq a seed.
void plan_recovery(const Trial& trial, const RivalsPlan& plan, const StopFlag* stop, StudyRunner& runner);
/// Empty without a truth.
RecoveryRecord summarise_recovery(const Trial& trial, const RivalsPlan& plan, const StudyRunner& runner);

}  // namespace lacuna
