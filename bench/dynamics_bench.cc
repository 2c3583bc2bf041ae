// Forward dynamics of the six-joint arm, one call a state; the state changes every iteration, so that nothing is cached.
#include <benchmark/benchmark.h>

#include "backends/featherstone/tree.h"
#include "bench/arm.h"

namespace lacuna::bench {
namespace {

constexpr std::size_t kJoints = 6;

/// Moves the state on without leaving a sensible range: a golden-ratio walk over [-1, 1].
struct State {
  double q[kJoints], v[kJoints], tau[kJoints], phase = 0.0;
  void next() {
    phase += 0.6180339887498949;
    phase -= static_cast<double>(static_cast<long>(phase));
    for (std::size_t j = 0; j < kJoints; ++j) {
      q[j] = 2.0 * phase - 1.0 + 0.1 * static_cast<double>(j);
      v[j] = 0.5 - phase;
      tau[j] = 20.0 * phase - 3.0 * static_cast<double>(j);
    }
  }
};

void engine_forward_dynamics(benchmark::State& bench, const Engine* engine) {
  auto dynamics = engine->build(arm_robot(), {0.0, 0.0, -9.81});
  State s;
  double a[kJoints];
  for (auto _ : bench) {
    s.next();
    dynamics->forward_dynamics(s.q, s.v, s.tau, a);
    benchmark::DoNotOptimize(a);
  }
}

/// Our kernel without the interface above it.
void featherstone_scalar(benchmark::State& bench) {
  const auto robot = arm_robot();
  Tree<double> tree(*robot);
  for (int i = 0; i < robot->dof(); ++i) tree.set_inertial(i, 0, robot->body_inertial(i));
  tree.set_gravity(0, {0.0, 0.0, -9.81});
  State s;
  const double free[kJoints] = {1, 1, 1, 1, 1, 1};
  double a[kJoints], imbalance[kJoints];
  for (auto _ : bench) {
    s.next();
    tree.forward_dynamics(s.q, s.v, s.tau, free, a, imbalance);
    benchmark::DoNotOptimize(a);
  }
}
BENCHMARK(featherstone_scalar);

const bool registered = [] {
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    benchmark::RegisterBenchmark(("forward_dynamics/" + engine->info().name).c_str(), &engine_forward_dynamics, engine);
  }
  return true;
}();

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
