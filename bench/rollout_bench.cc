// One rollout of two seconds at steps of 5 ms: every engine, and a full pack of lanes (time per item is per model).
#include <benchmark/benchmark.h>

#include "bench/arm.h"

namespace lacuna::bench {
namespace {

void rollout(benchmark::State& bench, const std::string& engine, int models) {
  const Scenario scenario = arm_scenario(2.0);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  SimulatorOptions options;
  options.engine = engine;
  auto simulator = make_simulator(model, experiment, options);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(models), model.values());
  const std::vector<int> segments{0};
  double factor = 1.0;
  for (auto _ : bench) {
    factor = factor > 1.1 ? 0.9 : factor + 1e-3;
    for (auto& v : values) v[0] = factor * model.values()[0];
    simulator->run(values, segments,
                   [](int, int, const auto& predicted) { benchmark::DoNotOptimize(predicted.data()); });
  }
  bench.SetItemsProcessed(bench.iterations() * models);
}

const bool registered = [] {
  benchmark::RegisterBenchmark(("rollout_2s/lanes_" + lane_info().name).c_str(), [](benchmark::State& bench) {
    rollout(bench, "featherstone", lane_info().width);
  })->Unit(benchmark::kMillisecond);
  for (const Engine* engine : engines()) {
    const EngineInfo info = engine->info();
    if (!info.available) continue;
    benchmark::RegisterBenchmark(("rollout_2s/" + info.name).c_str(), [name = info.name](benchmark::State& bench) {
      rollout(bench, name, 1);
    })->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
