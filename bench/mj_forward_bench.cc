// MuJoCo's whole mj_forward on the six-joint arm, as a user of MuJoCo calls it: the URDF loaded by MuJoCo itself, its
// default options, efforts as qfrc_applied. dynamics_bench times the part of it that rigid bodies need.
#include <benchmark/benchmark.h>

#include <memory>

#include "bench/mj_arm.h"

namespace lacuna::bench {
namespace {

void mj_forward_whole(benchmark::State& bench) {
  const auto model = arm_model();
  const std::unique_ptr<mjData, Deleter> data(mj_makeData(model.get()));
  double phase = 0.0;
  for (auto _ : bench) {
    // The walk over states of dynamics_bench.
    phase += 0.6180339887498949;
    phase -= static_cast<double>(static_cast<long>(phase));
    for (int j = 0; j < kJoints; ++j) {
      data->qpos[j] = 2.0 * phase - 1.0 + 0.1 * j;
      data->qvel[j] = 0.5 - phase;
      data->qfrc_applied[j] = 20.0 * phase - 3.0 * j;
    }
    mj_forward(model.get(), data.get());
    benchmark::DoNotOptimize(data->qacc);
  }
}
BENCHMARK(mj_forward_whole)->Name("mj_forward/mujoco");

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
