// MuJoCo's whole mj_forward on the six-joint arm, as a user of MuJoCo calls it: the URDF loaded by MuJoCo itself, its
// default options, efforts as qfrc_applied. dynamics_bench times the part of it that rigid bodies need.
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace lacuna::bench {
namespace {

constexpr int kJoints = 6;

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

std::unique_ptr<mjModel, Deleter> arm_model() {
  std::array<char, 500> error{};
  std::unique_ptr<mjModel, Deleter> model(mj_loadXML(LACUNA_SOURCE_DIR "/scenarios/hydrolek/seed_table1.urdf", nullptr,
                                                     error.data(), static_cast<int>(error.size())));
  if (model && model->nv == kJoints) return model;
  std::fprintf(stderr, "mj_forward_bench: no arm of %d joints: %s\n", kJoints, error.data());
  std::exit(3);
}

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
