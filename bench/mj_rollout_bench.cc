// Many parameter sets of the six-joint arm, two seconds each: our rollouts against MuJoCo's own stepping, as
// `mujoco.rollout` does it from C++: one mjModel a set with its own numbers, mj_step over them on threads.
//
// Both get the same machine: gain times command as qfrc_applied, held over a step of 5 ms, damping and stiffness the
// joints' own. MuJoCo steps by its Euler method (implicit in the damping) and by RK4; ours are steps of RK4. All three
// are run in turn in every iteration, so that a slow moment of the machine is slow for all:
//   mujoco_euler_over_ours, mujoco_rk4_over_ours   time of the other over time of ours
//   error_ours, error_euler, error_rk4             largest position error of the first set, rad, against ours at 0.25
//   ms
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include "bench/arm.h"
#include "bench/mj_arm.h"
#include "bench/runs.h"

namespace lacuna::bench {
namespace {

constexpr double kSeconds = 2.0, kStep = 0.005, kFine = 0.00025, kSample = 0.01;
using Positions = std::vector<std::array<double, kJoints>>;  // [sample]

double number(const ActuatorSpec& spec, const char* name) { return spec.parameters.at(name); }

/// The sets: gains spread by a tenth each way.
double gain_factor(int set, int sets) { return 0.9 + 0.2 * set / std::max(1, sets - 1); }

/// MuJoCo's models, one a set, stepped on threads.
class Mujoco {
 public:
  Mujoco(const Scenario& scenario, int sets, int threads)
      : scenario_(scenario), threads_(threads), models_(arm_model()) {
    mjModel* m = models_.get();
    m->opt.timestep = kStep;
    m->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_LIMIT;  // as ours: the arm alone
    for (int j = 0; j < kJoints; ++j) {
      const ActuatorSpec& spec = scenario.actuators[j];
      m->dof_damping[j] = number(spec, "damping");
      m->jnt_stiffness[j] = number(spec, "stiffness");
      m->qpos_spring[j] = number(spec, "rest");
    }
    for (int s = 0; s < sets; ++s) {
      each_.emplace_back(mj_copyModel(nullptr, m));
      data_.emplace_back(mj_makeData(m));
      for (int j = 0; j < kJoints; ++j) gains_.push_back(gain_factor(s, sets) * number(scenario.actuators[j], "gain"));
    }
  }

  double seconds(int integrator) {
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::thread> workers;
    for (int t = 0; t < threads_; ++t)
      workers.emplace_back([this, t, integrator] {
        for (std::size_t s = t; s < each_.size(); s += static_cast<std::size_t>(threads_)) run(s, integrator, nullptr);
      });
    for (std::thread& worker : workers) worker.join();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  Positions positions(int integrator) {
    Positions out;
    run(0, integrator, &out);
    return out;
  }

 private:
  void run(std::size_t set, int integrator, Positions* out) {
    mjModel* model = each_[set].get();
    mjData* data = data_[set].get();
    model->opt.integrator = integrator;
    mj_resetData(model, data);
    const Recording& commands = *scenario_.recordings.front().data;
    const int pieces = static_cast<int>(std::lround(kSample / kStep));
    for (std::size_t k = 0; k + 1 < commands.rows(); ++k) {
      if (out != nullptr) record(*data, *out);
      for (int j = 0; j < kJoints; ++j)
        data->qfrc_applied[j] = gains_[set * kJoints + j] * commands.columns[1 + 2 * static_cast<std::size_t>(j)][k];
      for (int piece = 0; piece < pieces; ++piece) mj_step(model, data);
    }
    if (out != nullptr) record(*data, *out);
    benchmark::DoNotOptimize(data->qpos);
  }

  static void record(const mjData& data, Positions& out) {
    out.emplace_back();
    std::copy_n(data.qpos, kJoints, out.back().begin());
  }

  const Scenario& scenario_;
  int threads_;
  std::unique_ptr<mjModel, Deleter> models_;
  std::vector<std::unique_ptr<mjModel, Deleter>> each_;
  std::vector<std::unique_ptr<mjData, Deleter>> data_;
  std::vector<double> gains_;
};

/// Ours, the sets' gains spread alike.
Runs ours_of(const Scenario& scenario, int sets, int threads, double step) {
  SimulatorOptions options;
  options.threads = threads;
  options.max_step = step;
  return Runs(scenario, options, sets, [sets](const PlantModel& model, int set, std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (model.parameters()[i].name.ends_with(".gain")) values[i] *= gain_factor(set, sets);
  });
}

Positions positions_of(Runs& runs) {
  const std::vector<std::vector<double>> predicted = runs.first();
  Positions out(predicted.front().size());
  for (std::size_t j = 0; j < kJoints; ++j)
    for (std::size_t k = 0; k < out.size(); ++k) out[k][j] = predicted[j][k];
  return out;
}

double largest_difference(const Positions& a, const Positions& b) {
  double out = a.size() == b.size() ? 0.0 : HUGE_VAL;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
    for (int j = 0; j < kJoints; ++j) out = std::max(out, std::fabs(a[k][j] - b[k][j]));
  return out;
}

void rollouts(benchmark::State& bench) {
  const int sets = static_cast<int>(bench.range(0)), threads = static_cast<int>(bench.range(1));
  const Scenario scenario = arm_scenario(kSeconds);
  Runs ours = ours_of(scenario, sets, threads, kStep), fine = ours_of(scenario, 1, 1, kFine);
  Mujoco mujoco(scenario, sets, threads);
  double by_ours = 0.0, by_euler = 0.0, by_rk4 = 0.0;
  for (auto _ : bench) {
    const double seconds = ours.seconds();
    by_ours += seconds, by_euler += mujoco.seconds(mjINT_EULER), by_rk4 += mujoco.seconds(mjINT_RK4);
    bench.SetIterationTime(seconds);
  }
  const Positions truth = positions_of(fine);
  bench.SetItemsProcessed(bench.iterations() * sets);
  bench.counters["mujoco_euler_over_ours"] = by_euler / by_ours;
  bench.counters["mujoco_rk4_over_ours"] = by_rk4 / by_ours;
  bench.counters["error_ours"] = largest_difference(positions_of(ours), truth);
  bench.counters["error_euler"] = largest_difference(mujoco.positions(mjINT_EULER), truth);
  bench.counters["error_rk4"] = largest_difference(mujoco.positions(mjINT_RK4), truth);
}
BENCHMARK(rollouts)
    ->Name("many_rollouts_2s")
    ->ArgNames({"sets", "threads"})
    ->Args({256, 1})
    ->Args({256, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

}  // namespace
}  // namespace lacuna::bench

BENCHMARK_MAIN();
