// The seed paper's genetic algorithm with its gaps made explicit. Every choice has an option whose default is the
// paper's final setting (its table 4).
#pragma once

#include <cstdint>
#include <vector>

#include "ga/coding.h"
#include "ga/operators.h"
#include "ga/optimizer.h"

namespace lacuna {

struct GeneticOptions {
  int population = 70;    ///< 2 .. 1000000
  int generations = 200;  ///< populations evaluated, the first one included; at least 1
  Coding coding = Coding::mvbs;
  Selection selection = Selection::roulette;
  int tournament_size = 2;                     ///< 1 .. population; tournament selection only
  Crossover crossover = Crossover::pointwise;  ///< uniform_bit needs MVBS coding
  int cut_points = 2;                          ///< at least 1; more than the string has places: all places
  double crossover_rate = 0.8;                 ///< Pc, chance that a pair is crossed; 0 .. 1
  Mutation mutation = Mutation::per_gene;      ///< per_bit needs MVBS coding
  double mutation_rate = 0.05;                 ///< Pm, per what `mutation` says; 0 .. 1
  int elite = 1;                               ///< best individuals kept unchanged; 0 .. population - 1
  std::uint64_t seed = 1;
  /// Points that replace the first individuals of the random first population, rounded to the coding's grid; at most
  /// `population`. The paper has none.
  std::vector<std::vector<double>> start_points;
};

/// Throws std::invalid_argument with the option's name, the value found and the range allowed.
void validate(const GeneticOptions& options, const Box& box);

/// Runs the algorithm. The same options, box and cost give the same result to the last bit, however the cost uses
/// threads and however often the run was stopped and resumed (only GenerationRecord::seconds differ).
///
/// A point is not evaluated again while it survives: costs are carried over from the generation before, and equal
/// individuals of a generation are evaluated once. `evaluations` counts what was really evaluated.
///
/// `best` lies on the coding's grid. If all evaluations failed, best_cost is infinity and `best` any individual.
/// The checkpoint holds a finished run too; the caller removes it with remove_checkpoint() once the result is safe.
/// It may be resumed with more generations; with any other change it is refused (InputError).
OptimizerResult run_genetic_algorithm(const Box& box, const BatchCost& cost, const GeneticOptions& options,
                                      const RunControl& control = {});

}  // namespace lacuna
