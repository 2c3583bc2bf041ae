// The genetic algorithm's cost call on a recording of ten seconds: the seed's population of 70, which on lanes of 8
// makes an odd number of packs, and one of whole packs; and what the machine itself gives to a second thread.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <functional>
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
    points_.assign(size, space_.start());
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

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a second thread gains: one thread and two in turns, so that a machine that slows down slows down for both.
/// `apart` is the same work by two threads that share nothing, each with half of the population as its own: what the
/// machine has to give to a second thread at the time, and so the bound for `gain`.
void second_thread(benchmark::State& bench) {
  const int size = static_cast<int>(bench.range(0));
  Population one(size, 1), two(size, 2), left(size / 2, 1), right(size - size / 2, 1);
  std::vector<double> gain, apart;
  for (auto _ : bench) {
    const double alone = seconds_of([&] { one.evaluate(); });
    gain.push_back(alone / seconds_of([&] { two.evaluate(); }));
    apart.push_back(alone / seconds_of([&] {
                      std::jthread other([&] { right.evaluate(); });
                      left.evaluate();
                    }));
  }
  bench.counters["gain"] = median(gain);
  bench.counters["apart"] = median(apart);
}
BENCHMARK(second_thread)->ArgName("population")->Arg(70)->Arg(256)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
