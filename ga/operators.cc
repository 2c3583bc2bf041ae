#include "ga/operators.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "ga/enum_names.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 4> selection_names = {"roulette", "roulette_literal", "tournament", "rank"};
constexpr std::array<const char*, 3> crossover_names = {"pointwise", "uniform_gene", "uniform_bit"};
constexpr std::array<const char*, 3> mutation_names = {"per_gene", "per_bit", "per_chromosome"};

/// Chance of the worst relative to the best in the corrected roulette.
constexpr double roulette_epsilon = 1e-6;

/// Weight 1 for all that did not fail, or for all if all failed.
std::vector<double> equal_weights(std::span<const double> costs) {
  const bool all_failed = std::none_of(costs.begin(), costs.end(), [](double c) { return std::isfinite(c); });
  std::vector<double> weights(costs.size());
  std::transform(costs.begin(), costs.end(), weights.begin(),
                 [&](double c) { return all_failed || std::isfinite(c) ? 1.0 : 0.0; });
  return weights;
}

std::vector<double> roulette_weights(std::span<const double> costs, double best, double worst) {
  std::vector<double> weights(costs.size(), 0.0);
  // Halves, because the spread of finite costs may overflow.
  const double spread = 0.5 * worst - 0.5 * best;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (std::isfinite(costs[i])) weights[i] = (0.5 * worst - 0.5 * costs[i]) / spread + roulette_epsilon;
  }
  return weights;
}

std::vector<double> literal_weights(std::span<const double> costs, double best, double worst) {
  std::vector<double> weights(costs.size(), 0.0);
  const double largest = std::max(std::abs(best), std::abs(worst));
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (std::isfinite(costs[i])) weights[i] = std::abs(costs[i]) / largest;
  }
  return weights;
}

std::vector<double> rank_weights(std::span<const double> costs) {
  std::vector<double> weights(costs.size(), 0.0);
  const auto order = ranking(costs);
  for (std::size_t place = 0; place < order.size(); ++place) {
    if (std::isfinite(costs[order[place]])) weights[order[place]] = static_cast<double>(costs.size() - place);
  }
  return weights;
}

/// Exchanges the bits of `mask` between two genes.
void exchange_bits(Gene& a, Gene& b, Gene mask) {
  const Gene difference = static_cast<Gene>((a ^ b) & mask);
  a = static_cast<Gene>(a ^ difference);
  b = static_cast<Gene>(b ^ difference);
}

/// Mask of the bits of one gene from position `from` to before `to` (0 .. 16, most significant first).
Gene segment_mask(int from, int to) {
  const std::uint32_t above_end = 0xFFFFu >> from, after_end = 0xFFFFu >> to;
  return static_cast<Gene>(above_end & ~after_end);
}

void exchange_segment(Coding coding, int from, int to, Chromosome& a, Chromosome& b) {
  const int width = coding == Coding::mvbs ? bits_per_gene : 1;
  for (int gene = from / width; gene * width < to; ++gene) {
    if (coding == Coding::integer) {
      std::swap(a[gene], b[gene]);
    } else {
      const int start = gene * width;
      exchange_bits(a[gene], b[gene], segment_mask(std::max(from - start, 0), std::min(to - start, width)));
    }
  }
}

/// One bit flipped, or in integer coding another value.
void mutate_gene(Coding coding, Gene& gene, RandomStream& stream) {
  if (coding == Coding::mvbs) {
    gene = static_cast<Gene>(gene ^ (1u << stream.below(bits_per_gene)));
  } else {
    gene = static_cast<Gene>(gene + 1u + stream.below(largest_gene));
  }
}

}  // namespace

const char* to_string(Selection selection) { return selection_names[static_cast<std::size_t>(selection)]; }
Selection selection_from_name(const std::string& name) {
  return enum_from_name<Selection>("selection", selection_names, name);
}
const char* to_string(Crossover crossover) { return crossover_names[static_cast<std::size_t>(crossover)]; }
Crossover crossover_from_name(const std::string& name) {
  return enum_from_name<Crossover>("crossover", crossover_names, name);
}
const char* to_string(Mutation mutation) { return mutation_names[static_cast<std::size_t>(mutation)]; }
Mutation mutation_from_name(const std::string& name) {
  return enum_from_name<Mutation>("mutation", mutation_names, name);
}

std::vector<std::size_t> ranking(std::span<const double> costs) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const bool a_valid = std::isfinite(costs[a]), b_valid = std::isfinite(costs[b]);
    return a_valid && b_valid ? costs[a] < costs[b] : a_valid && !b_valid;
  });
  return order;
}

std::vector<double> selection_weights(Selection selection, std::span<const double> costs) {
  double best = std::numeric_limits<double>::infinity(), worst = -best;
  for (const double c : costs) {
    if (!std::isfinite(c)) continue;
    best = std::min(best, c);
    worst = std::max(worst, c);
  }
  // Differences below the smallest normal number vanish when halved; they are no reason to choose either.
  if (!(0.5 * worst > 0.5 * best)) return equal_weights(costs);
  switch (selection) {
    case Selection::roulette: return roulette_weights(costs, best, worst);
    case Selection::roulette_literal: return literal_weights(costs, best, worst);
    case Selection::rank: return rank_weights(costs);
    case Selection::tournament: break;
  }
  throw std::logic_error("selection_weights: tournament selection has no weights");
}

Selector::Selector(Selection selection, std::span<const double> costs, int tournament_size)
    : tournament_size_(tournament_size) {
  if (selection == Selection::tournament) {
    const auto order = ranking(costs);
    rank_.resize(order.size());
    for (std::size_t place = 0; place < order.size(); ++place) rank_[order[place]] = place;
  } else {
    cumulative_ = selection_weights(selection, costs);
    std::partial_sum(cumulative_.begin(), cumulative_.end(), cumulative_.begin());
  }
}

std::size_t Selector::pick(RandomStream& stream) const {
  if (cumulative_.empty()) {
    std::size_t best = stream.below(rank_.size());
    for (int i = 1; i < tournament_size_; ++i) {
      const std::size_t rival = stream.below(rank_.size());
      if (rank_[rival] < rank_[best]) best = rival;
    }
    return best;
  }
  const double total = cumulative_.back();
  // A weight of zero leaves its running sum equal to the one before, which upper_bound passes over. The product can
  // round up to the total; then the last individual with a weight is meant.
  const auto place = std::upper_bound(cumulative_.begin(), cumulative_.end(), stream.uniform() * total);
  if (place != cumulative_.end()) return static_cast<std::size_t>(place - cumulative_.begin());
  return static_cast<std::size_t>(std::lower_bound(cumulative_.begin(), cumulative_.end(), total) -
                                  cumulative_.begin());
}

void crossover_pointwise(Coding coding, std::span<const int> cuts, Chromosome& a, Chromosome& b) {
  for (std::size_t i = 0; i < cuts.size(); i += 2) {
    const int end = i + 1 < cuts.size() ? cuts[i + 1] : string_length(coding, a.size());
    exchange_segment(coding, cuts[i], end, a, b);
  }
}

void crossover_uniform_gene(Chromosome& a, Chromosome& b) {
  for (std::size_t i = 1; i < a.size(); i += 2) std::swap(a[i], b[i]);
}

void crossover_uniform_bit(Chromosome& a, Chromosome& b) {
  constexpr Gene odd_positions = 0x5555;  // positions count from the most significant bit
  for (std::size_t i = 0; i < a.size(); ++i) exchange_bits(a[i], b[i], odd_positions);
}

std::vector<int> draw_cuts(int length, int count, RandomStream& stream) {
  std::vector<int> cuts;
  const int places = length - 1;
  // Floyd's sampling: `count` draws, no rejection, every subset equally likely.
  for (int last = places - std::min(count, places) + 1; last <= places; ++last) {
    const int draw = 1 + static_cast<int>(stream.below(static_cast<std::uint64_t>(last)));
    const bool taken = std::find(cuts.begin(), cuts.end(), draw) != cuts.end();
    cuts.push_back(taken ? last : draw);
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

void cross(Crossover crossover, int cut_points, Coding coding, Chromosome& a, Chromosome& b, RandomStream& stream) {
  switch (crossover) {
    case Crossover::pointwise:
      crossover_pointwise(coding, draw_cuts(string_length(coding, a.size()), cut_points, stream), a, b);
      return;
    case Crossover::uniform_gene: crossover_uniform_gene(a, b); return;
    case Crossover::uniform_bit: crossover_uniform_bit(a, b); return;
  }
}

void flip_bit(Chromosome& chromosome, int position) {
  Gene& gene = chromosome[static_cast<std::size_t>(position / bits_per_gene)];
  gene = static_cast<Gene>(gene ^ (0x8000u >> position % bits_per_gene));
}

void mutate(Mutation mutation, double rate, Coding coding, Chromosome& chromosome, RandomStream& stream) {
  switch (mutation) {
    case Mutation::per_gene:
      for (Gene& gene : chromosome) {
        if (stream.chance(rate)) mutate_gene(coding, gene, stream);
      }
      return;
    case Mutation::per_bit:
      for (int position = 0; position < string_length(Coding::mvbs, chromosome.size()); ++position) {
        if (stream.chance(rate)) flip_bit(chromosome, position);
      }
      return;
    case Mutation::per_chromosome:
      if (stream.chance(rate)) mutate_gene(coding, chromosome[stream.below(chromosome.size())], stream);
      return;
  }
}

}  // namespace lacuna
