#include "physics/simulator.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "physics/predictor.h"

namespace lacuna {
namespace {

struct LaneChoice {
  const char* name;
  int width;
  PredictorMaker make;
};

/// Widest lanes that both the build and this CPU have.
const LaneChoice& lane_choice() {
  static const LaneChoice choice = [] {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
      return LaneChoice{"avx512", 8, &make_predictor_avx512};
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
      return LaneChoice{"avx2", 4, &make_predictor_avx2};
    }
#endif
    return LaneChoice{"sse2", 2, &make_predictor_sse2};
  }();
  return choice;
}

class PopulationSimulator final : public Simulator {
 public:
  PopulationSimulator(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options)
      : experiment_(experiment), options_(options) {
    const int workers = std::max(1, options.threads);
    for (int w = 0; w < workers; ++w) {
      workers_.push_back(options.engine == "featherstone" ? lane_choice().make(model, experiment)
                                                          : make_engine_predictor(options.engine, model, experiment));
    }
  }

  int lanes() const override { return workers_.front()->lanes(); }

  void run(std::span<const std::vector<double>> individuals, std::span<const int> segments,
           const PredictionVisitor& visit) override {
    const int width = lanes(), count = static_cast<int>(individuals.size());
    const int packs = (count + width - 1) / width;
    const int pieces = packs * static_cast<int>(segments.size());
    parallel_for(
        static_cast<int>(workers_.size()), pieces,
        [&](int worker, int piece) {
          const int segment = segments[static_cast<std::size_t>(piece / packs)];
          const int first = piece % packs * width, last = std::min(count, first + width);
          std::vector<const std::vector<double>*> pack;
          for (int i = first; i < last; ++i) pack.push_back(&individuals[static_cast<std::size_t>(i)]);
          std::vector<std::vector<std::vector<double>>> predicted;
          workers_[static_cast<std::size_t>(worker)]->predict(
              pack, experiment_.segments[static_cast<std::size_t>(segment)], options_.max_step, predicted);
          for (int i = first; i < last; ++i) visit(i, segment, predicted[static_cast<std::size_t>(i - first)]);
        },
        options_.stop);
  }

 private:
  const Experiment& experiment_;
  SimulatorOptions options_;
  std::vector<std::unique_ptr<Predictor>> workers_;
};

}  // namespace

std::unique_ptr<Simulator> make_simulator(const PlantModel& model, const Experiment& experiment,
                                          const SimulatorOptions& options) {
  return std::make_unique<PopulationSimulator>(model, experiment, options);
}

LaneInfo lane_info() { return {lane_choice().name, lane_choice().width}; }

StepChoice choose_step(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options,
                       std::span<const double> values) {
  constexpr double kFinest = 1.0e-4;  // s
  constexpr double kShare = 0.1;      // of the noise, the project's rule
  // Steps end at samples, so a step longer than the sampling period is none.
  const double coarsest = std::min(0.010, experiment.sample_period);
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return {coarsest, 0.0};
  std::vector<int> segments = experiment.with_role(Role::train);
  if (segments.size() > 12) segments.resize(12);  // windows: the first dozen
  const std::vector<std::vector<double>> one{std::vector<double>(values.begin(), values.end())};
  auto predict = [&](double step) {
    SimulatorOptions with = options;
    with.max_step = step;
    std::vector<std::vector<std::vector<double>>> out(experiment.segments.size());
    make_simulator(model, experiment, with)->run(one, segments, [&](int, int s, const auto& predicted) {
      out[static_cast<std::size_t>(s)] = predicted;
    });
    return out;
  };
  StepChoice choice{coarsest, HUGE_VAL};
  auto coarse = predict(choice.step);
  for (;;) {
    const auto fine = predict(0.5 * choice.step);
    double worst = 0.0;
    for (const int s : segments) {
      for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
        const double noise = experiment.channels[c].noise;
        if (!(noise > 0.0)) continue;
        const auto& a = coarse[static_cast<std::size_t>(s)][c];
        const auto& b = fine[static_cast<std::size_t>(s)][c];
        double sum = 0.0;
        for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
        const double error = std::sqrt(sum / static_cast<double>(a.size())) * (16.0 / 15.0) / noise;
        worst = std::isfinite(error) ? std::max(worst, error) : HUGE_VAL;
      }
    }
    choice.error_over_noise = worst;
    if (worst < kShare || 0.5 * choice.step < kFinest) return choice;
    coarse = fine;
    choice.step *= 0.5;
  }
}

}  // namespace lacuna
