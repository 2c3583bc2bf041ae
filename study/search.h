// One run of one optimiser on a task, and every optimiser that a study compares.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ga/genetic_algorithm.h"
#include "study/trial.h"

namespace lacuna {

/// One run. `curve`: best cost so far against evaluations, one entry a generation or start.
struct SearchRun {
  std::vector<double> point;  ///< of the trial's box
  double cost = 0.0;          ///< of `point`, as the run's fitness says (no denominator: output_unit)
  long evaluations = 0;       ///< simulations of all train segments
  struct Entry {
    long evaluations = 0;
    double best = 0.0;
  };
  std::vector<Entry> curve;
  double seconds = 0.0;
  AnswerErrors errors;
};

/// The genetic algorithm with one of the paper's fitness functions. Throws Interrupted.
SearchRun run_genetic(Task task, const GeneticOptions& options, Fitness fitness);

/// Everything else lowers the two-norm, which least squares do too.
enum class SearchMethod { ga, cmaes, de, pso, sga, multi_start, ga_lsq };
const char* to_string(SearchMethod method);
std::string title_of(SearchMethod method);
std::vector<SearchMethod> all_methods();

struct Budget {
  int population = 70;
  long evaluations = 14000;  ///< a run ends with the generation or start that reaches it
  std::uint64_t seed = 1;
  int round_generations = 20;  ///< of `ga_lsq`: generations before each least-squares finish
};
/// `ga`: the paper's final setting with the two-norm; `cmaes` to `sga`: pagmo's, same population; `multi_start`: least
/// squares from random points of the box, again and again; `ga_lsq`: some generations of `ga`, then least
/// squares from its best, again and again. Throws Interrupted.
SearchRun run_method(Task task, SearchMethod method, const Budget& budget);

}  // namespace lacuna
