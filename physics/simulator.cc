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
      : experiment_(experiment),
        max_step_(options.max_step),
        alone_(make_executor(options.threads, nullptr, options.stop)),
        shared_(make_executor(options.threads, options.ranks, options.stop)) {
    for (int w = 0; w < alone_->workers(); ++w) {
      workers_.push_back(options.engine == "featherstone" ? lane_choice().make(model, experiment)
                                                          : make_engine_predictor(options.engine, model, experiment));
    }
  }

  int lanes() const override { return workers_.front()->lanes(); }

  void run(std::span<const std::vector<double>> individuals, std::span<const int> segments,
           const PredictionVisitor& visit) override {
    run_on(*alone_, individuals, segments, visit, nullptr);
  }
  void run(std::span<const std::vector<double>> individuals, std::span<const int> segments,
           const PredictionVisitor& visit, const PairResult& result) override {
    run_on(*shared_, individuals, segments, visit, result);
  }

 private:
  /// A piece is one pack of individuals on one segment.
  void run_on(Executor& executor, std::span<const std::vector<double>> individuals, std::span<const int> segments,
              const PredictionVisitor& visit, const PairResult& result) {
    const int width = lanes(), count = static_cast<int>(individuals.size());
    const int packs = (count + width - 1) / width;
    const auto segment_of = [&](int piece) { return segments[static_cast<std::size_t>(piece / packs)]; };
    const auto first_of = [&](int piece) { return piece % packs * width; };
    const PieceWork simulate = [&](int worker, int piece) {
      const int segment = segment_of(piece), first = first_of(piece), last = std::min(count, first + width);
      std::vector<const std::vector<double>*> pack;
      for (int i = first; i < last; ++i) pack.push_back(&individuals[static_cast<std::size_t>(i)]);
      std::vector<std::vector<std::vector<double>>> predicted;
      workers_[static_cast<std::size_t>(worker)]->predict(pack, experiment_.segments[static_cast<std::size_t>(segment)],
                                                          max_step_, predicted);
      for (int i = first; i < last; ++i) visit(i, segment, predicted[static_cast<std::size_t>(i - first)]);
    };
    const PieceResults results = [&](int piece) {
      std::vector<std::span<std::byte>> out;
      for (int i = first_of(piece); i < std::min(count, first_of(piece) + width); ++i)
        out.push_back(result(i, segment_of(piece)));
      return out;
    };
    executor.run(packs * static_cast<int>(segments.size()), simulate, results, key_of(individuals, segments));
  }

  std::uint64_t key_of(std::span<const std::vector<double>> individuals, std::span<const int> segments) const {
    std::uint64_t key = hash_of(std::as_bytes(segments), hash_of(std::as_bytes(std::span(&max_step_, 1))));
    for (const std::vector<double>& values : individuals) key = hash_of(std::as_bytes(std::span(values)), key);
    return key;
  }

  const Experiment& experiment_;
  double max_step_;
  std::unique_ptr<Executor> alone_, shared_;
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
    std::vector<std::vector<double>> out(experiment.segments.size());  // channel by channel
    for (const int s : segments) {
      const std::size_t at = static_cast<std::size_t>(s);
      out[at].resize(experiment.channels.size() * experiment.segments[at].count);
    }
    make_simulator(model, experiment, with)
        ->run(
            one, segments,
            [&](int, int s, const auto& predicted) {
              auto to = out[static_cast<std::size_t>(s)].begin();
              for (const std::vector<double>& channel : predicted) to = std::copy(channel.begin(), channel.end(), to);
            },
            [&](int, int s) { return std::as_writable_bytes(std::span(out[static_cast<std::size_t>(s)])); });
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
        const std::size_t count = experiment.segments[static_cast<std::size_t>(s)].count;
        const double* a = coarse[static_cast<std::size_t>(s)].data() + c * count;
        const double* b = fine[static_cast<std::size_t>(s)].data() + c * count;
        double sum = 0.0;
        for (std::size_t k = 0; k < count; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
        const double error = std::sqrt(sum / static_cast<double>(count)) * kErrorOverChange / noise;
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
