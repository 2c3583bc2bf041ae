// The genetic algorithm's cost call on a recording of ten seconds: the seed's population of 70, which on lanes of 8 makes
// an odd number of packs, and one of whole packs.
#include <benchmark/benchmark.h>

#include "bench/arm.h"
#include "ga/problem.h"

namespace lacuna::bench {
namespace {

void population_cost(benchmark::State& bench) {
  const Scenario scenario = arm_scenario(10.0);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario);
  SimulatorOptions options;
  options.threads = static_cast<int>(bench.range(1));
  Problem problem(model, experiment, space, options, first_weights(model, experiment));
  std::vector<std::vector<double>> points(static_cast<std::size_t>(bench.range(0)), space.start());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i][0] *= 0.7 + 0.6 * static_cast<double>(i) / static_cast<double>(points.size());
  std::vector<double> costs(points.size());
  const std::vector<int> train = experiment.with_role(Role::train);
  for (auto _ : bench) {
    problem.costs(points, costs, train, Fitness::norm_2);
    benchmark::DoNotOptimize(costs.data());
  }
  bench.SetItemsProcessed(bench.iterations() * static_cast<int64_t>(points.size()));
}
BENCHMARK(population_cost)
    ->ArgNames({"population", "threads"})
    ->ArgsProduct({{70, 256}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
