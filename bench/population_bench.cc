// The genetic algorithm's cost call on a recording of ten seconds: the seed's population of 70, which on lanes of 8 makes
// an odd number of packs, and one of whole packs; and what the machine itself gives to a second thread.
#include <benchmark/benchmark.h>

#include <memory>
#include <thread>
#include <vector>

#include "bench/arm.h"
#include "ga/problem.h"

namespace lacuna::bench {
namespace {

/// A population and all that its costs need, shared with nobody.
class Population {
 public:
  Population(int size, int threads)
      : space_(model_, scenario_),
        problem_(model_, experiment_, space_, on(threads), first_weights(model_, experiment_)) {
    points_.assign(static_cast<std::size_t>(size), space_.start());
    for (std::size_t i = 0; i < points_.size(); ++i)
      points_[i][0] *= 0.7 + 0.6 * static_cast<double>(i) / static_cast<double>(points_.size());
    costs_.resize(points_.size());
  }

  void evaluate() {
    problem_.costs(points_, costs_, train_, Fitness::norm_2);
    benchmark::DoNotOptimize(costs_.data());
  }

 private:
  static SimulatorOptions on(int threads) {
    SimulatorOptions out;
    out.threads = threads;
    return out;
  }

  Scenario scenario_ = arm_scenario(10.0);
  PlantModel model_{scenario_};
  Experiment experiment_ = make_experiment(scenario_);
  SearchSpace space_;
  Problem problem_;
  std::vector<std::vector<double>> points_;
  std::vector<double> costs_;
  std::vector<int> train_ = experiment_.with_role(Role::train);
};

void population_cost(benchmark::State& bench) {
  const int size = static_cast<int>(bench.range(0));
  Population population(size, static_cast<int>(bench.range(1)));
  for (auto _ : bench) population.evaluate();
  bench.SetItemsProcessed(bench.iterations() * size);
}
BENCHMARK(population_cost)
    ->ArgNames({"population", "threads"})
    ->ArgsProduct({{70, 256}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// The same work by threads that share nothing, each with a population of its own: what the machine has to give to a
/// second thread at the time, and so the bound for the scaling of population_cost.
void populations_apart(benchmark::State& bench) {
  constexpr int kSize = 256;
  const int threads = static_cast<int>(bench.range(0));
  std::vector<std::unique_ptr<Population>> parts;
  for (int k = 0; k < threads; ++k) parts.push_back(std::make_unique<Population>(kSize / threads, 1));
  for (auto _ : bench) {
    std::vector<std::thread> team;
    for (const auto& part : parts) team.emplace_back([&part] { part->evaluate(); });
    for (std::thread& one : team) one.join();
  }
  bench.SetItemsProcessed(bench.iterations() * kSize);
}
BENCHMARK(populations_apart)->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
