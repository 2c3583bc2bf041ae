// The six-joint arm: forward dynamics, one native step, poses on every engine, and our kernel alone, scalar and in
// lanes (items: models). The state changes every iteration, so that nothing is cached.
#include <benchmark/benchmark.h>

#include "backends/featherstone/tree.h"
#include "bench/arm.h"
#include "bench/lanes/lane_forward.h"

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

void engine_step(benchmark::State& bench, const Engine* engine) {
  auto dynamics = engine->build(arm_robot(), {0.0, 0.0, -9.81});
  const std::string integrator = engine->info().native_integrators.front();
  State s;
  for (auto _ : bench) {
    s.next();
    dynamics->native_step(integrator, s.q, s.v, s.tau, 1e-3);
    benchmark::DoNotOptimize(s.q);
  }
  bench.SetLabel(integrator);
}

void engine_poses(benchmark::State& bench, const Engine* engine) {
  auto dynamics = engine->build(arm_robot(), {0.0, 0.0, -9.81});
  std::vector<Eigen::Isometry3d> poses;
  State s;
  for (auto _ : bench) {
    s.next();
    dynamics->body_poses(s.q, poses);
    benchmark::DoNotOptimize(poses.data());
  }
}

/// The widest pack that build and CPU have.
void featherstone_lanes(benchmark::State& bench) {
  const auto robot = arm_robot();
  const LaneInfo info = lane_info();
  auto lanes = info.name == "avx512" ? make_lane_forward_avx512(*robot)
               : info.name == "avx2" ? make_lane_forward_avx2(*robot)
                                     : make_lane_forward_sse2(*robot);
  State s;
  for (auto _ : bench) {
    s.next();
    benchmark::DoNotOptimize(lanes->run(s.q, s.v, s.tau));
  }
  bench.SetItemsProcessed(bench.iterations() * info.width);
  bench.SetLabel(info.name);
}
BENCHMARK(featherstone_lanes);

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
    benchmark::RegisterBenchmark(("step/" + engine->info().name).c_str(), &engine_step, engine);
    benchmark::RegisterBenchmark(("poses/" + engine->info().name).c_str(), &engine_poses, engine);
  }
  return true;
}();

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
