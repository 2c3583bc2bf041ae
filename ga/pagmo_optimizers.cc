#include "ga/pagmo_optimizers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/pso_gen.hpp>
#include <pagmo/algorithms/sade.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <stdexcept>

#include "ga/checkpoint.h"
#include "ga/enum_names.h"
#include "ga/random.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 4> method_names = {"cmaes", "de", "pso", "sga"};

using Points = std::vector<std::vector<double>>;

/// Stands for a failed evaluation inside pagmo, which compares and subtracts costs and so needs finite ones.
constexpr double failed_cost = 1e300;

/// Most algorithms evaluate point by point, but choose all points of a generation before they look at its costs. So
/// each generation is run twice: once on copies, only to learn the points, then, after these were evaluated together,
/// in earnest. The second run is identical because the algorithm's random state is part of what is copied.
struct Exchange {
  bool rehearsing = false;
  Points asked;                 // by the rehearsal
  std::vector<double> answers;  // to `asked`
  std::size_t next = 0;         // answer that the run in earnest comes to
  std::function<double(const std::vector<double>&)> evaluate_alone;

  double answer(const std::vector<double>& x) {
    if (rehearsing) {
      asked.push_back(x);
      return 0.0;
    }
    if (next < asked.size() && asked[next] == x) return answers[next++];
    // An algorithm whose points depended on costs of the same generation would still be right, only slower.
    return evaluate_alone(x);
  }
};

struct UnitCubeProblem {
  std::shared_ptr<Exchange> exchange;
  std::size_t dimension = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return {exchange->answer(x)}; }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimension, 0.0), pagmo::vector_double(dimension, 1.0)};
  }
};

pagmo::algorithm make_algorithm(PagmoMethod method, unsigned seed) {
  // Steps under 1e-10 of the box no longer matter; a cost, whose unit we do not know, never ends a run.
  constexpr double cost_tolerance = 0.0, step_tolerance = 1e-10;
  switch (method) {
    case PagmoMethod::cmaes:
      return pagmo::algorithm(pagmo::cmaes(1, -1, -1, -1, -1, 0.3, cost_tolerance, step_tolerance, true, true, seed));
    case PagmoMethod::de: return pagmo::algorithm(pagmo::sade(1, 2, 1, cost_tolerance, 0.0, true, seed));
    case PagmoMethod::pso: break;
    case PagmoMethod::sga:
      return pagmo::algorithm(pagmo::sga(1, 0.9, 1.0, 0.02, 1.0, 2, "exponential", "polynomial", "tournament", seed));
  }
  throw std::logic_error("make_algorithm: the swarm is not run by single generations");
}

/// Ends pagmo's loop over generations from inside an evaluation.
struct SwarmStopped {};

/// The one algorithm that can hand a whole generation to a batch evaluator: one point after another in `flat`.
struct SwarmBatch {
  std::function<std::vector<double>(const Points&)> generation;

  pagmo::vector_double operator()(const pagmo::problem& problem, const pagmo::vector_double& flat) const {
    const auto dimension = static_cast<std::ptrdiff_t>(problem.get_nx());
    Points points;
    for (auto x = flat.begin(); x != flat.end(); x += dimension) points.emplace_back(x, x + dimension);
    return generation(points);
  }
};

int smallest_population(PagmoMethod method) {
  switch (method) {
    case PagmoMethod::cmaes: return 5;
    case PagmoMethod::de: return 7;
    default: return 2;
  }
}

RunIdentity identity_of(const Box& box, const PagmoOptions& options, const RunControl& control) {
  std::string points;
  for (const auto& point : options.start_points) {
    for (const double value : point) points += exact_text(value) + " ";
  }
  return {.optimizer = std::string("pagmo ") + to_string(options.method),
          .options = {{"population", std::to_string(options.population)},
                      {"seed", std::to_string(options.seed)},
                      {"start_points", points}},
          .box = box,
          .problem = control.problem};
}

/// One run. pagmo's state is not stored: a checkpoint holds the costs of all evaluations, and a resumed run replays
/// them through the algorithm, which takes no time beside the simulations they came from.
class PagmoRun {
 public:
  PagmoRun(const Box& box, const BatchCost& cost, const PagmoOptions& options, const RunControl& control)
      : box_(box), cost_(cost), options_(options), control_(control), identity_(identity_of(box, options, control)) {
    state_.best_cost = std::numeric_limits<double>::infinity();
    exchange_->evaluate_alone = [this](const std::vector<double>& x) { return evaluate_points({x}).front(); };
  }

  OptimizerResult run() {
    if (!control_.checkpoint.empty()) replay_ = load_checkpoint(control_.checkpoint, identity_);
    if (replay_) check_replay_fits();
    while (state_.history.size() < wanted() && may_continue()) {
      if (!population_) {
        start();
        finish_generation();
      } else if (options_.method == PagmoMethod::pso) {
        swarm_to_the_end();
      } else if (advance()) {
        finish_generation();
      } else {
        population_.reset();
        ++starts_;
      }
    }
    return {.best = state_.best,
            .best_cost = state_.best_cost,
            .evaluations = state_.evaluations,
            .history = state_.history,
            .interrupted = state_.history.size() < wanted()};
  }

 private:
  std::size_t wanted() const { return static_cast<std::size_t>(options_.generations); }
  bool stopped() const { return control_.stop && control_.stop->load(); }
  bool may_continue() const { return replaying() || !stopped(); }
  bool replaying() const { return replay_ && state_.history.size() < replay_->history.size(); }

  void check_replay_fits() const {
    if (replay_->history.size() <= wanted()) return;
    throw InputError(control_.checkpoint.string(), fmt::format("{} generations done", replay_->history.size()),
                     fmt::format("at most generations = {}; remove the file to start anew", options_.generations));
  }

  /// A random population, the first time with the caller's points in it, and a fresh algorithm.
  void start() {
    Points points(static_cast<std::size_t>(options_.population), std::vector<double>(box_.lower.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      RandomStream draws(options_.seed, starts_, static_cast<std::uint32_t>(i));
      for (double& x : points[i]) x = draws.uniform();
      if (starts_ == 0 && i < options_.start_points.size()) points[i] = to_unit(options_.start_points[i]);
    }
    const auto costs = evaluate_points(points);
    constexpr std::uint32_t seeding = 1;
    seed_ = RandomStream(options_.seed, starts_, 0, seeding).bits32();
    population_.emplace(UnitCubeProblem{exchange_, box_.lower.size()}, 0u, seed_);
    for (std::size_t i = 0; i < points.size(); ++i) population_->push_back(points[i], {costs[i]});
    if (options_.method != PagmoMethod::pso) algorithm_ = make_algorithm(options_.method, seed_);
  }

  /// All generations that are left. The library's swarm forgets part of its state between calls, memory or not, and
  /// then hardly converges; so it is not run by single generations like the others.
  void swarm_to_the_end() {
    const auto left = static_cast<unsigned>(wanted() - state_.history.size());
    pagmo::pso_gen swarm(left, 0.7298, 2.05, 2.05, 0.5, 5, 2, 4, false, seed_);
    swarm.set_bfe(pagmo::bfe(SwarmBatch{[this](const Points& points) {
      if (!may_continue()) throw SwarmStopped();
      auto costs = evaluate_points(points);
      finish_generation();
      return costs;
    }}));
    try {
      swarm.evolve(*population_);
    } catch (const SwarmStopped&) {
    }
  }

  /// One generation; false if the algorithm has converged and asks for nothing more.
  bool advance() {
    exchange_->asked.clear();
    exchange_->rehearsing = true;
    pagmo::algorithm(algorithm_).evolve(*population_);
    exchange_->rehearsing = false;
    const auto is_lost = [](const std::vector<double>& x) {
      return std::any_of(x.begin(), x.end(), [](double v) { return !std::isfinite(v); });
    };
    // A covariance that has collapsed shows as points that are not numbers.
    if (exchange_->asked.empty() || std::any_of(exchange_->asked.begin(), exchange_->asked.end(), is_lost)) {
      return false;
    }
    exchange_->answers = evaluate_points(exchange_->asked);
    exchange_->next = 0;
    population_ = algorithm_.evolve(*population_);
    return true;
  }

  /// Costs as pagmo sees them, from the checkpoint as far as it reaches; keeps the best and the journal.
  std::vector<double> evaluate_points(const Points& unit_points) {
    Points points;
    for (const auto& x : unit_points) points.push_back(from_unit(x));
    std::vector<double> costs;
    const std::size_t done = state_.costs.size();
    if (replay_ && done + points.size() <= replay_->costs.size()) {
      const auto first = replay_->costs.begin() + static_cast<std::ptrdiff_t>(done);
      costs.assign(first, first + static_cast<std::ptrdiff_t>(points.size()));
    } else {
      costs = evaluate(cost_, points);
    }
    state_.costs.insert(state_.costs.end(), costs.begin(), costs.end());
    state_.evaluations += static_cast<long>(costs.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!state_.best.empty() && !(costs[i] < state_.best_cost)) continue;
      state_.best = points[i];
      state_.best_cost = costs[i];
    }
    last_points_.insert(last_points_.end(), points.begin(), points.end());
    last_costs_.insert(last_costs_.end(), costs.begin(), costs.end());
    for (double& c : costs) c = std::min(c, failed_cost);
    return costs;
  }

  void finish_generation() {
    const bool replayed = replaying();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    state_.history.push_back(record_generation(last_points_, last_costs_, box_, state_.best_cost, state_.evaluations,
                                               seconds_before_ + seconds));
    last_points_.clear();
    last_costs_.clear();
    if (replayed) {
      state_.history.back().seconds = replay_->history[state_.history.size() - 1].seconds;
      if (!replaying()) end_replay();
      return;
    }
    if (control_.writes && !control_.checkpoint.empty()) save_checkpoint(control_.checkpoint, identity_, state_);
    if (control_.progress) {
      control_.progress({.stage = std::string("pagmo ") + to_string(options_.method),
                         .done = static_cast<double>(state_.history.size()) / options_.generations,
                         .best_cost = state_.best_cost,
                         .evaluations = state_.evaluations});
    }
  }

  /// The replay must have arrived where the stored run was; another version of the library might not.
  void end_replay() {
    if (state_.best != replay_->best || state_.costs != replay_->costs) {
      throw InputError(control_.checkpoint.string(), "a run that this program's pagmo library does not repeat",
                       "one of the same library version; remove the file to start anew");
    }
    seconds_before_ = state_.history.back().seconds;
    start_ = std::chrono::steady_clock::now();
  }

  std::vector<double> to_unit(const std::vector<double>& point) const {
    std::vector<double> x(point.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::clamp((point[i] - box_.lower[i]) / (box_.upper[i] - box_.lower[i]), 0.0, 1.0);
    }
    return x;
  }

  std::vector<double> from_unit(const std::vector<double>& x) const {
    std::vector<double> point(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      point[i] = std::clamp(box_.lower[i] + (box_.upper[i] - box_.lower[i]) * x[i], box_.lower[i], box_.upper[i]);
    }
    return point;
  }

  const Box& box_;
  const BatchCost& cost_;
  const PagmoOptions& options_;
  const RunControl& control_;
  RunIdentity identity_;
  Checkpoint state_;
  std::optional<Checkpoint> replay_;
  std::shared_ptr<Exchange> exchange_ = std::make_shared<Exchange>();
  std::optional<pagmo::population> population_;  // empty before a start
  pagmo::algorithm algorithm_;
  std::uint32_t starts_ = 0;  // starts given up so far
  unsigned seed_ = 0;         // of the present start
  Points last_points_;        // of the generation under way
  std::vector<double> last_costs_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double seconds_before_ = 0.0;
};

}  // namespace

const char* to_string(PagmoMethod method) { return method_names[static_cast<std::size_t>(method)]; }
PagmoMethod pagmo_method_from_name(const std::string& name) {
  return enum_from_name<PagmoMethod>("optimizer", method_names, name);
}

void validate(const PagmoOptions& options, const Box& box) {
  validate(box);
  const int smallest = smallest_population(options.method), largest = 1'000'000;
  if (options.population < smallest || options.population > largest) {
    throw std::invalid_argument(fmt::format("population = {}, allowed for {}: {} .. {}", options.population,
                                            to_string(options.method), smallest, largest));
  }
  if (options.generations < 1) {
    throw std::invalid_argument(fmt::format("generations = {}, allowed: at least 1", options.generations));
  }
  if (options.start_points.size() > static_cast<std::size_t>(options.population)) {
    throw std::invalid_argument(
        fmt::format("start_points = {} points, allowed: 0 .. {}", options.start_points.size(), options.population));
  }
  validate_points("start_points", options.start_points, box);
}

OptimizerResult run_pagmo(const Box& box, const BatchCost& cost, const PagmoOptions& options,
                          const RunControl& control) {
  validate(options, box);
  return PagmoRun(box, cost, options, control).run();
}

}  // namespace lacuna
