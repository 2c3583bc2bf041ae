// One rollout of two seconds at steps of 5 ms: every engine, and a full pack of lanes (time per item is per model); the
// same arm on hydraulic actuators, beside which `hydraulic_over_torque` gives the time over that of torque sources,
// both taken in turn in one run.
#include <benchmark/benchmark.h>

#include "bench/arm.h"
#include "bench/runs.h"

namespace lacuna::bench {
namespace {

void rollout(benchmark::State& bench, const std::string& engine, int models) {
  const Scenario scenario = arm_scenario(2.0);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  SimulatorOptions options;
  options.engine = engine;
  auto simulator = make_simulator(model, experiment, options);
  std::vector<std::vector<double>> values(models, model.values());
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

/// Side by side: the counter is the ratio of the sums.
void hydraulic_rollout(benchmark::State& bench, const std::string& engine, int models) {
  SimulatorOptions options;
  options.engine = engine;
  Runs torque(arm_scenario(2.0), options, models), oil(hydraulic_arm_scenario(2.0), options, models);
  double by_torque = 0.0, by_oil = 0.0;
  for (auto _ : bench) {
    by_torque += torque.seconds();
    const double seconds = oil.seconds();
    by_oil += seconds;
    bench.SetIterationTime(seconds);
  }
  bench.SetItemsProcessed(bench.iterations() * models);
  bench.counters["hydraulic_over_torque"] = by_oil / by_torque;
}

void register_hydraulic(const std::string& name, const std::string& engine, int models) {
  benchmark::RegisterBenchmark(("rollout_2s_hydraulic/" + name).c_str(),
                               [engine, models](benchmark::State& bench) { hydraulic_rollout(bench, engine, models); })
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
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
  register_hydraulic("lanes_" + lane_info().name, "featherstone", lane_info().width);
  for (const Engine* engine : engines())
    if (engine->info().available) register_hydraulic(engine->info().name, engine->info().name, 1);
  return true;
}();

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
