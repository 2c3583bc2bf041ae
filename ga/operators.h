// Selection, crossover and mutation, each on the coded individuals. The plain operators below are deterministic; the
// calls with a stream draw what they need and apply them.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "ga/coding.h"
#include "ga/random.h"

namespace lacuna {

/// How parents are drawn. In all of them failed individuals (cost not finite) are never preferred to others.
enum class Selection {
  roulette,          ///< weight cost_worst - cost + eps: the seed's roulette, corrected
  roulette_literal,  ///< weight fit / sum(fit) with the seed's negative fit: favours the worst; for the study only
  tournament,        ///< the best of some drawn with replacement
  rank               ///< weight falls linearly from the best (n) to the worst (1)
};
const char* to_string(Selection selection);
Selection selection_from_name(const std::string& name);

enum class Crossover {
  pointwise,     ///< cut at k places, every other segment exchanged
  uniform_gene,  ///< every other gene exchanged
  uniform_bit    ///< every other bit exchanged; MVBS coding only
};
const char* to_string(Crossover crossover);
Crossover crossover_from_name(const std::string& name);

enum class Mutation {
  per_gene,       ///< each gene, with the rate: one random bit flipped
  per_bit,        ///< each bit, with the rate: flipped; MVBS coding only
  per_chromosome  ///< each chromosome, with the rate: one random bit of all flipped
};
const char* to_string(Mutation mutation);
Mutation mutation_from_name(const std::string& name);

/// Indices from best to worst: failed last, equals in the order of their index.
std::vector<std::size_t> ranking(std::span<const double> costs);

/// Weights of the roulettes and of rank selection, in any unit; failed individuals have weight 0. All are 1 when the
/// costs give no reason to choose (all equal or all failed). Throws std::logic_error for tournament, which has none.
///
/// roulette: (worst - cost) / (worst - best) + 1e-6, so that the worst keeps a small chance.
/// roulette_literal: |cost| (for costs >= 0, the seed's fit over its sum).
std::vector<double> selection_weights(Selection selection, std::span<const double> costs);

/// Draws parents from one evaluated population.
class Selector {
 public:
  /// `tournament_size` is used by tournament selection only, at least 1.
  Selector(Selection selection, std::span<const double> costs, int tournament_size);

  /// Index of one parent.
  std::size_t pick(RandomStream& stream) const;

 private:
  std::vector<std::size_t> rank_;   // tournament: place of each individual in the ranking
  std::vector<double> cumulative_;  // other selections: running sum of the weights
  int tournament_size_;
};

/// Positions on the string of a chromosome: MVBS: bit p is bit 15 - p % 16 of gene p / 16 (most significant first);
/// integer: position p is gene p. A cut at c separates positions c - 1 and c.
///
/// Exchanges the second, fourth, ... segment between ascending cuts, each in 1 .. length - 1.
void crossover_pointwise(Coding coding, std::span<const int> cuts, Chromosome& a, Chromosome& b);

/// Exchanges genes 1, 3, 5, ...
void crossover_uniform_gene(Chromosome& a, Chromosome& b);

/// Exchanges bits 1, 3, 5, ...
void crossover_uniform_bit(Chromosome& a, Chromosome& b);

/// `count` different cuts of a string of `length` positions, ascending, all choices equally likely. All places
/// (length - 1 of them) if there are fewer than `count`.
std::vector<int> draw_cuts(int length, int count, RandomStream& stream);

/// Turns two parents into two children. `cut_points` is used by pointwise crossover only.
void cross(Crossover crossover, int cut_points, Coding coding, Chromosome& a, Chromosome& b, RandomStream& stream);

/// Flips the bit at a position (MVBS numbering) of the chromosome.
void flip_bit(Chromosome& chromosome, int position);

/// In integer coding "one random bit flipped" reads: the gene replaced by another value, all equally likely.
void mutate(Mutation mutation, double rate, Coding coding, Chromosome& chromosome, RandomStream& stream);

}  // namespace lacuna
