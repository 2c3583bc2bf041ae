#include "study/search.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "ga/enum_names.h"
#include "ga/least_squares.h"
#include "ga/pagmo_optimizers.h"
#include "ga/random.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 7> kMethodNames = {"ga", "cmaes", "de", "pso", "sga", "multi_start", "ga_lsq"};
constexpr std::array<const char*, 7> kMethodTitles = {"the paper's GA",         "CMA-ES",
                                                      "differential evolution", "particle swarm",
                                                      "pagmo's simple GA",      "multi-start least squares",
                                                      "GA, then least squares"};

/// Use of random draws: starts of least squares.
constexpr std::uint32_t kStarts = 61;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// A run under way.
class Search {
 public:
  Search(Task task, Fitness fitness)
      : task_(std::move(task)),
        fitness_(fitness),
        problem_(*task_.trial.model, task_.experiment, task_.space, task_.simulator, task_.weights) {
    run_.cost = std::numeric_limits<double>::infinity();
  }

  const Task& task() const { return task_; }
  Problem& problem() { return problem_; }
  long evaluations() const { return run_.evaluations; }
  const std::vector<double>& best() const { return run_.point; }
  bool found() const { return std::isfinite(run_.cost); }

  BatchCost cost() {
    return [this](std::span<const std::vector<double>> points, std::span<double> out) {
      std::vector<std::vector<double>> inner;
      for (const auto& point : points) inner.push_back(inner_point(task_, point));
      problem_.costs(inner, out, task_.train, fitness_);
      for (double& cost : out) cost *= scale();
    };
  }

  RunControl control() const {
    RunControl out;
    out.stop = task_.simulator.stop;
    return out;
  }

  /// Adds a population search's history to the curve.
  void take(const OptimizerResult& result) {
    if (result.interrupted) throw Interrupted();
    const double before = run_.cost;
    for (const GenerationRecord& record : result.history)
      run_.curve.push_back({run_.evaluations + record.evaluations, std::min(record.best, before)});
    run_.evaluations += result.evaluations;
    offer(result.best, result.best_cost);
  }

  /// Least squares from a point of the box; a start that cannot be simulated costs one evaluation.
  void descend(const std::vector<double>& from) {
    if (task_.simulator.stop != nullptr && task_.simulator.stop->load()) throw Interrupted();
    LeastSquaresOptions options;
    options.control = control();
    try {
      const LeastSquaresResult found = solve_least_squares(problem_, inner_point(task_, from), task_.train, options);
      // Its last residual and Jacobian are simulations too.
      run_.evaluations += found.evaluations + 2 + static_cast<long>(task_.space.size());
      offer(outer_point(task_, found.point, from), scale() * std::sqrt(found.sum_of_squares));
    } catch (const WorkError&) {
      ++run_.evaluations;
    }
    run_.curve.push_back({run_.evaluations, run_.cost});
  }

  SearchRun finish(double began) {
    if (!found()) throw WorkError("every simulation of a search diverged");
    run_.errors = errors_of(problem_, task_, run_.point);
    run_.seconds = now() - began;
    return run_;
  }

 private:
  double scale() const { return is_relative(fitness_) ? 1.0 : task_.trial.output_scale; }
  void offer(const std::vector<double>& point, double cost) {
    if (!(cost < run_.cost)) return;
    run_.cost = cost;
    run_.point = point;
  }

  Task task_;
  Fitness fitness_;
  Problem problem_;
  SearchRun run_;
};

std::vector<double> random_point(const Box& box, std::uint64_t seed, std::uint32_t number) {
  RandomStream draws(seed, number, 0, kStarts);
  std::vector<double> out;
  for (std::size_t i = 0; i < box.lower.size(); ++i) out.push_back(draws.uniform(box.lower[i], box.upper[i]));
  return out;
}

int generations_of(const Budget& budget) {
  return static_cast<int>(std::max(1L, budget.evaluations / budget.population));
}

GeneticOptions genetic_of(const Budget& budget) {
  GeneticOptions out;
  out.population = budget.population;
  out.generations = generations_of(budget);
  out.seed = budget.seed;
  return out;
}

void search_with_pagmo(Search& search, PagmoMethod method, const Budget& budget) {
  PagmoOptions options;
  options.method = method;
  options.population = budget.population;
  options.generations = generations_of(budget);
  options.seed = budget.seed;
  search.take(run_pagmo(search.task().box, search.cost(), options, search.control()));
}

void search_again_and_again(Search& search, bool genetic, const Budget& budget) {
  for (std::uint32_t round = 0; search.evaluations() < budget.evaluations; ++round) {
    std::vector<double> from = random_point(search.task().box, budget.seed, round);
    if (genetic) {
      GeneticOptions options = genetic_of(budget);
      options.generations = budget.round_generations;
      options.seed = budget.seed + (std::uint64_t{round} << 32);
      const OptimizerResult found = run_genetic_algorithm(search.task().box, search.cost(), options, search.control());
      search.take(found);
      if (!found.best.empty()) from = found.best;
    }
    search.descend(from);
  }
}

}  // namespace

const char* to_string(SearchMethod method) { return kMethodNames[static_cast<std::size_t>(method)]; }
std::string title_of(SearchMethod method) { return kMethodTitles[static_cast<std::size_t>(method)]; }
std::vector<SearchMethod> all_methods() {
  std::vector<SearchMethod> out;
  for (std::size_t i = 0; i < kMethodNames.size(); ++i) out.push_back(static_cast<SearchMethod>(i));
  return out;
}

SearchRun run_genetic(Task task, const GeneticOptions& options, Fitness fitness) {
  const double began = now();
  Search search(std::move(task), fitness);
  search.take(run_genetic_algorithm(search.task().box, search.cost(), options, search.control()));
  return search.finish(began);
}

SearchRun run_method(Task task, SearchMethod method, const Budget& budget) {
  const double began = now();
  Search search(std::move(task), Fitness::norm_2);
  switch (method) {
    case SearchMethod::ga:
      search.take(run_genetic_algorithm(search.task().box, search.cost(), genetic_of(budget), search.control()));
      break;
    case SearchMethod::cmaes: search_with_pagmo(search, PagmoMethod::cmaes, budget); break;
    case SearchMethod::de: search_with_pagmo(search, PagmoMethod::de, budget); break;
    case SearchMethod::pso: search_with_pagmo(search, PagmoMethod::pso, budget); break;
    case SearchMethod::sga: search_with_pagmo(search, PagmoMethod::sga, budget); break;
    case SearchMethod::multi_start: search_again_and_again(search, false, budget); break;
    case SearchMethod::ga_lsq: search_again_and_again(search, true, budget); break;
  }
  return search.finish(began);
}

}  // namespace lacuna
