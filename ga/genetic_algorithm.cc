#include "ga/genetic_algorithm.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "ga/random.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

template <typename T>
void require_range(const char* option, T value, T lowest, T highest) {
  if (value >= lowest && value <= highest) return;  // also refuses NaN
  throw std::invalid_argument(fmt::format("{} = {}, allowed: {} .. {}", option, value, lowest, highest));
}

RunIdentity identity_of(const Box& box, const GeneticOptions& o, const RunControl& control) {
  RunIdentity identity{.optimizer = "genetic algorithm", .options = {}, .box = box, .problem = control.problem};
  identity.options = {{"population", std::to_string(o.population)},
                      {"coding", to_string(o.coding)},
                      {"selection", to_string(o.selection)},
                      {"tournament_size", std::to_string(o.tournament_size)},
                      {"crossover", to_string(o.crossover)},
                      {"cut_points", std::to_string(o.cut_points)},
                      {"crossover_rate", exact_text(o.crossover_rate)},
                      {"mutation", to_string(o.mutation)},
                      {"mutation_rate", exact_text(o.mutation_rate)},
                      {"elite", std::to_string(o.elite)},
                      {"seed", std::to_string(o.seed)}};
  std::string points;
  for (const auto& point : o.start_points) {
    for (const Gene gene : encode(point, box)) points += fmt::format("{} ", gene);
  }
  identity.options.emplace_back("start_points", points);
  return identity;
}

/// One run. The state after a generation is exactly what a checkpoint holds.
class Evolution {
 public:
  Evolution(const Box& box, const BatchCost& cost, const GeneticOptions& options, const RunControl& control)
      : box_(box), cost_(cost), options_(options), control_(control), identity_(identity_of(box, options, control)) {
    state_.best_cost = std::numeric_limits<double>::infinity();
  }

  OptimizerResult run() {
    resume();
    const std::size_t wanted = options_.generations;
    while (state_.history.size() < wanted && !stopped()) {
      evaluate_generation(state_.history.empty() ? first_population() : next_population());
      finish_generation();
    }
    return {.best = state_.best,
            .best_cost = state_.best_cost,
            .evaluations = state_.evaluations,
            .history = state_.history,
            .interrupted = state_.history.size() < wanted};
  }

 private:
  bool stopped() const { return control_.stop && control_.stop->load(); }

  RandomStream stream(std::size_t individual) const {
    return {options_.seed, static_cast<std::uint32_t>(state_.history.size()), static_cast<std::uint32_t>(individual)};
  }

  void resume() {
    if (control_.checkpoint.empty()) return;
    auto loaded = load_checkpoint(control_.checkpoint, identity_);
    if (!loaded) return;
    const auto is_wrong = [&](const Chromosome& c) { return c.size() != box_.lower.size(); };
    const std::size_t size = options_.population;
    if (loaded->history.empty() || loaded->population.size() != size || loaded->costs.size() != size ||
        loaded->best.size() != box_.lower.size() ||
        std::any_of(loaded->population.begin(), loaded->population.end(), is_wrong)) {
      throw InputError(control_.checkpoint.string(), "a population of another shape",
                       fmt::format("{} individuals of {} genes", size, box_.lower.size()));
    }
    if (loaded->history.size() > static_cast<std::size_t>(options_.generations)) {
      throw InputError(control_.checkpoint.string(), fmt::format("{} generations done", loaded->history.size()),
                       fmt::format("at most generations = {}; remove the file to start anew", options_.generations));
    }
    state_ = std::move(*loaded);
    seconds_before_ = state_.history.back().seconds;
  }

  std::vector<Chromosome> first_population() const {
    std::vector<Chromosome> population(options_.population, Chromosome(box_.lower.size()));
    for (std::size_t i = 0; i < population.size(); ++i) {
      if (i < options_.start_points.size()) {
        population[i] = encode(options_.start_points[i], box_);
        continue;
      }
      RandomStream draws = stream(i);
      for (Gene& gene : population[i]) gene = static_cast<Gene>(draws.below(largest_gene + 1u));
    }
    return population;
  }

  /// The elite, then the children of pairs; of the last pair only the first child if the number is odd.
  std::vector<Chromosome> next_population() const {
    const auto& parents = state_.population;
    const auto order = ranking(state_.costs);
    const Selector selector(options_.selection, state_.costs, options_.tournament_size);
    std::vector<Chromosome> children;
    for (std::size_t i = 0; i < static_cast<std::size_t>(options_.elite); ++i) children.push_back(parents[order[i]]);
    while (children.size() < parents.size()) {
      RandomStream draws = stream(children.size());
      Chromosome a = parents[selector.pick(draws)], b = parents[selector.pick(draws)];
      if (draws.chance(options_.crossover_rate)) {
        cross(options_.crossover, options_.cut_points, options_.coding, a, b, draws);
      }
      mutate(options_.mutation, options_.mutation_rate, options_.coding, a, draws);
      mutate(options_.mutation, options_.mutation_rate, options_.coding, b, draws);
      children.push_back(std::move(a));
      if (children.size() < parents.size()) children.push_back(std::move(b));
    }
    return children;
  }

  /// Makes `population` the current one, asking only for costs that are not known from the generation before.
  void evaluate_generation(std::vector<Chromosome> population) {
    std::map<Chromosome, double> known;
    for (std::size_t i = 0; i < state_.population.size(); ++i) known[state_.population[i]] = state_.costs[i];
    std::vector<const Chromosome*> asked;
    std::vector<std::vector<double>> points;
    for (const auto& chromosome : population) {
      if (!known.try_emplace(chromosome, 0.0).second) continue;
      asked.push_back(&chromosome);
      points.push_back(decode(chromosome, box_));
    }
    const auto costs = evaluate(cost_, points);
    for (std::size_t i = 0; i < asked.size(); ++i) known[*asked[i]] = costs[i];
    state_.evaluations += static_cast<long>(asked.size());
    state_.costs.clear();
    for (const auto& chromosome : population) state_.costs.push_back(known[chromosome]);
    state_.population = std::move(population);
  }

  void finish_generation() {
    const std::size_t best = ranking(state_.costs).front();
    if (state_.best.empty() || state_.costs[best] < state_.best_cost) {
      state_.best = decode(state_.population[best], box_);
      state_.best_cost = state_.costs[best];
    }
    std::vector<std::vector<double>> points;
    for (const auto& chromosome : state_.population) points.push_back(decode(chromosome, box_));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    state_.history.push_back(
        record_generation(points, state_.costs, box_, state_.best_cost, state_.evaluations, seconds_before_ + seconds));
    if (control_.writes && !control_.checkpoint.empty()) save_checkpoint(control_.checkpoint, identity_, state_);
    if (control_.progress) {
      control_.progress({.stage = "genetic algorithm",
                         .done = static_cast<double>(state_.history.size()) / options_.generations,
                         .best_cost = state_.best_cost,
                         .evaluations = state_.evaluations});
    }
  }

  const Box& box_;
  const BatchCost& cost_;
  const GeneticOptions& options_;
  const RunControl& control_;
  RunIdentity identity_;
  Checkpoint state_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double seconds_before_ = 0.0;
};

}  // namespace

void validate(const GeneticOptions& options, const Box& box) {
  validate(box);
  require_range("population", options.population, 2, 1'000'000);
  require_range("generations", options.generations, 1, 1'000'000'000);
  require_range("tournament_size", options.tournament_size, 1,
                options.selection == Selection::tournament ? options.population : 1'000'000);
  require_range("cut_points", options.cut_points, 1, 1'000'000);
  require_range("crossover_rate", options.crossover_rate, 0.0, 1.0);
  require_range("mutation_rate", options.mutation_rate, 0.0, 1.0);
  require_range("elite", options.elite, 0, options.population - 1);
  if (options.coding == Coding::integer && options.crossover == Crossover::uniform_bit) {
    throw std::invalid_argument("crossover = uniform_bit, allowed with coding = integer: pointwise, uniform_gene");
  }
  if (options.coding == Coding::integer && options.mutation == Mutation::per_bit) {
    throw std::invalid_argument("mutation = per_bit, allowed with coding = integer: per_gene, per_chromosome");
  }
  require_range("start_points", options.start_points.size(), std::size_t{0},
                static_cast<std::size_t>(options.population));
  validate_points("start_points", options.start_points, box);
}

OptimizerResult run_genetic_algorithm(const Box& box, const BatchCost& cost, const GeneticOptions& options,
                                      const RunControl& control) {
  validate(options, box);
  return Evolution(box, cost, options, control).run();
}

}  // namespace lacuna
