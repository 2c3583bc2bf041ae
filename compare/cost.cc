#include "compare/cost.h"

#include <malloc.h>

#include <algorithm>

#include "backends/engine.h"
#include "physics/cpu_clock.h"
#include "scenarios/error.h"
#include "compare/agreement.h"

namespace lacuna {
namespace {

constexpr int kRepeats = 9, kBuilds = 5;
constexpr int kStates = 64;           // that an evaluation is timed over: no state twice in a row
constexpr double kShortest = 2e-3;    // s, of a timed loop
constexpr double kLongestTry = 0.05;  // s, of one timed run: longer ones are repeated thrice only

void check(const StopFlag* stop) {
  if (stop != nullptr && *stop) throw Interrupted();
}

/// Bytes in use by this process' heap.
double heap_bytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// One engine being timed.
class Clocked {
 public:
  Clocked(const std::string& engine, const Motion& motion, std::uint64_t seed)
      : bodies_(motion.model.inertials(motion.phases.front().values)) {
    const double before = heap_bytes();
    dynamics_ = find_engine(engine).build(motion.model.robot_ptr(), motion.model.gravity());
    memory_ = heap_bytes() - before;
    for (int k = 0; k < kStates; ++k) states_.push_back(random_state(motion.model.robot(), seed, k));
    a_.resize(bodies_.size());
    evaluate_state(0);
    const double once = std::max(seconds_of([&] { evaluate_state(1); }), 1e-9);
    // Few states of a slow engine, the same ones many times of a fast one.
    count_ = std::clamp(static_cast<int>(kLongestTry / once), 2, kStates);
    loops_ = std::max(1, static_cast<int>(kShortest / (once * count_)));
  }

  double memory() const { return memory_; }
  double forward_ns() {
    return 1e9 * seconds_of([&] {
             for (int k = 0; k < loops_; ++k) evaluate();
           }) /
           (loops_ * count_);
  }
  /// A change of one body and an evaluation after it.
  double changed_ns() {
    return 1e9 * seconds_of([&] {
             for (int k = 0; k < loops_; ++k) change();
           }) /
           (loops_ * count_);
  }

 private:
  template <class Work>
  static double seconds_of(const Work& work) {
    const double begun = thread_cpu_seconds();
    work();
    return thread_cpu_seconds() - begun;
  }
  void evaluate() {
    for (int k = 0; k < count_; ++k) evaluate_state(static_cast<std::size_t>(k));
  }
  void evaluate_state(std::size_t k) { dynamics_->forward_dynamics(states_[k].q, states_[k].v, states_[k].tau, a_); }
  void change() {
    for (std::size_t k = 0; k < static_cast<std::size_t>(count_); ++k) {
      const std::size_t body = k % bodies_.size();
      dynamics_->set_inertial(static_cast<int>(body), bodies_[body].scaled(1.0 + 1e-3 * static_cast<double>(k % 7)));
      evaluate_state(k);
    }
  }

  std::vector<Inertial> bodies_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<RandomState> states_;
  std::vector<double> a_;
  double memory_ = 0.0;
  int count_ = kStates, loops_ = 1;
};

/// Timings of one engine, in the order taken.
struct Timings {
  std::vector<double> forward, change, build;
};

double build_us(const std::string& engine, const Motion& motion) {
  const double begun = thread_cpu_seconds();
  const auto dynamics = find_engine(engine).build(motion.model.robot_ptr(), motion.model.gravity());
  return 1e6 * (thread_cpu_seconds() - begun);
}

/// An evaluation within a method with step control costs what one of the four of a common step does.
void price_points(EngineComparison& engine) {
  for (MethodResult& method : engine.methods) {
    const double ns =
        method.adaptive() ? 0.25 * engine.method(kCommonMethod).ns_per_step.median : method.ns_per_step.median;
    for (WorkPoint& point : method.points) point.cpu_per_second = 1e-9 * ns * point.steps_per_second;
  }
}

}  // namespace

void measure_engine_costs(const Motion& motion, std::uint64_t seed, std::vector<EngineComparison>& engines,
                          const StopFlag* stop) {
  std::vector<std::unique_ptr<Clocked>> clocked(engines.size());
  std::vector<Timings> taken(engines.size());
  for (std::size_t e = 0; e < engines.size(); ++e) {
    if (!engines[e].available) continue;
    clocked[e] = std::make_unique<Clocked>(engines[e].engine, motion, seed);
    if (clocked[e]->memory() > 0.0) engines[e].memory_bytes = clocked[e]->memory();
  }
  for (int round = 0; round < kRepeats; ++round) {
    for (std::size_t e = 0; e < engines.size(); ++e) {
      check(stop);
      if (!clocked[e]) continue;
      taken[e].forward.push_back(clocked[e]->forward_ns());
      taken[e].change.push_back(clocked[e]->changed_ns() - taken[e].forward.back());
      if (round < kBuilds) taken[e].build.push_back(build_us(engines[e].engine, motion));
    }
  }
  for (std::size_t e = 0; e < engines.size(); ++e) {
    if (!clocked[e]) continue;
    engines[e].forward_ns = timing_of(taken[e].forward);
    engines[e].set_inertial_ns = timing_of(taken[e].change);
    engines[e].build_us = timing_of(taken[e].build);
  }
}

void measure_step_costs(std::vector<std::unique_ptr<Runner>>& runners, double step,
                        std::vector<EngineComparison>& engines, const StopFlag* stop) {
  struct Job {
    MethodResult* method;
    Runner* runner;
    std::vector<double> ns;
    double longest = 0.0;
  };
  std::vector<Job> jobs;
  for (std::size_t e = 0; e < engines.size(); ++e) {
    for (MethodResult& method : engines[e].methods) {
      if (runners[e] && method.not_run.empty() && !method.adaptive()) jobs.push_back({&method, runners[e].get(), {}});
    }
  }
  for (int round = 0; round < kRepeats; ++round) {
    for (Job& job : jobs) {
      check(stop);
      if (round >= 3 && job.longest > kLongestTry) continue;
      const Trajectory run = job.runner->run({job.method->name, job.method->native}, step);
      job.ns.push_back(1e9 * run.seconds / static_cast<double>(run.steps));
      job.longest = std::max(job.longest, run.seconds);
    }
  }
  for (Job& job : jobs) {
    job.method->ns_per_step = timing_of(job.ns);
    const double steps_per_second = 1.0 / step;
    job.method->realtime_factor = 1e9 / (job.method->ns_per_step.median * steps_per_second);
  }
  for (EngineComparison& engine : engines) {
    if (engine.available) price_points(engine);
  }
}

}  // namespace lacuna
