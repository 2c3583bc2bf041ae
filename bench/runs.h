// Simulations of a scenario's first recording with many parameter sets at once, timed by the clock on the wall: for
// benchmarks that run two things in turn.
#pragma once

#include <benchmark/benchmark.h>

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "physics/simulator.h"
#include "scenarios/scenario.h"

namespace lacuna::bench {

class Runs {
 public:
  /// Changes one set's parameter values, given its number.
  using Vary = std::function<void(const PlantModel& model, int set, std::vector<double>& values)>;

  Runs(const Scenario& scenario, const SimulatorOptions& options, int sets, const Vary& vary = nullptr)
      : model_(scenario),
        experiment_(make_experiment(scenario)),
        simulator_(make_simulator(model_, experiment_, options)),
        values_(sets, model_.values()) {
    for (int set = 0; vary && set < sets; ++set) vary(model_, set, values_[set]);
  }
  Runs(const Runs&) = delete;  // the simulator looks at what stands beside it

  double seconds() {
    const auto begin = std::chrono::steady_clock::now();
    simulator_->run(values_, segments_,
                    [](int, int, const auto& predicted) { benchmark::DoNotOptimize(predicted.data()); });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  /// [channel][sample], of the first set.
  std::vector<std::vector<double>> first() {
    std::vector<std::vector<double>> out;
    const std::vector<std::vector<double>> one{values_.front()};
    simulator_->run(one, segments_, [&](int, int, const auto& predicted) { out = predicted; });
    return out;
  }

 private:
  PlantModel model_;
  Experiment experiment_;
  std::unique_ptr<Simulator> simulator_;
  std::vector<std::vector<double>> values_;
  const std::vector<int> segments_{0};
};

}  // namespace lacuna::bench
