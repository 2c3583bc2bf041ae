// The seed paper's experiments on its genetic algorithm, redone over many seeds, and what lies beyond them: what the
// data determine at all, other optimisers on the same budget, bad data and bad bounds.
//
// One file an experiment. Each plans its runs, which are then carried out together (runner.h), and sums them up in a
// plain record. Claims are judged from the records by stated rules (conclusions.h), never by what the paper says.
#pragma once

#include <string>
#include <vector>

#include "study/conclusions.h"
#include "study/grid.h"
#include "study/identifiability.h"
#include "study/rivals.h"
#include "study/robustness.h"

namespace lacuna {

struct StudyOptions {
  int seeds = 5;           ///< runs a setting
  std::uint64_t seed = 1;  ///< of the first run; the others follow on
  int population = 70, generations = 200;
  int engine_generations = 10;     ///< of the final setting on engines without lanes
  std::vector<std::string> parts;  ///< of study_parts(); empty: what suits the scenario
  RunnerOptions runner;
};

/// "grid", "engines", "identifiability", "rivals", "robustness", "recovery".
std::vector<std::string> study_parts();

/// A part that was left out, and why.
struct SkippedPart {
  std::string part, reason;
};

struct Study {
  std::string scenario;
  std::vector<std::string> parameters, units;
  std::vector<double> start, lower, upper;  ///< parameter values (not search coordinates)
  std::vector<double> truth;                ///< empty: nobody knows
  std::string truth_file;
  std::vector<std::string> fixed;  ///< joints locked by brakes, simulated as fixed
  std::string output_unit;
  StepChoice step;
  std::string data;  ///< in words: where the train recordings come from
  int seeds = 0, population = 0, generations = 0;
  GridRecord grid;
  std::vector<EngineRecord> engines;
  std::vector<Excitation> identifiability;
  RivalsRecord rivals;
  RobustnessRecord robustness;
  RecoveryRecord recovery;
  std::vector<Conclusion> conclusions;
  std::vector<SkippedPart> skipped;
  long evaluations = 0;
  double run_seconds = 0.0;  ///< summed over all runs, those of an earlier, interrupted call included
};

/// Runs the parts. `truth`: see make_trial(); null: nobody knows. Throws InputError, WorkError, Interrupted.
Study run_study(const Scenario& scenario, const Scenario* truth, const StudyOptions& options);

}  // namespace lacuna
