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

  std::vector<LinearMotion> linearise(const std::vector<double>& values, std::span<const int> segments,
                                      const std::vector<double>& effort_sizes) override {
    std::vector<LinearMotion> out(segments.size());
    on_pieces(static_cast<int>(segments.size()), [&](int worker, int k) {
      const LaneTask task{&values, &experiment_.segments[segments[k]]};
      out[k] = workers_[worker]->linearise(task, max_step_, effort_sizes);
    });
    return out;
  }

  void excess(std::span<const std::vector<double>> individuals, std::span<const int> segments,
              std::span<const LinearMotion> motions, const PredictionVisitor& visit) override {
    const std::size_t width = lanes();
    const std::size_t packs = (individuals.size() + width - 1) / width;
    on_pieces(static_cast<int>(packs * segments.size()), [&](int worker, int piece) {
      const std::size_t at = static_cast<std::size_t>(piece) / packs,
                        first = static_cast<std::size_t>(piece) % packs * width;
      std::vector<LaneTask> tasks;
      for (std::size_t i = first; i < std::min(first + width, individuals.size()); ++i)
        tasks.push_back({&individuals[i], &experiment_.segments[segments[at]]});
      std::vector<std::vector<std::vector<double>>> efforts;
      workers_[worker]->excess(tasks, motions[at], efforts);
      for (std::size_t i = 0; i < tasks.size(); ++i) visit(static_cast<int>(first + i), segments[at], efforts[i]);
    });
  }

 private:
  /// In this process alone, whoever shares the simulations.
  void on_pieces(int pieces, const PieceWork& work) {
    alone_->run(
        pieces, work, [](int) { return std::vector<std::span<std::byte>>{}; }, 0);
  }

  struct Pair {
    int individual, segment;
  };

  /// One pack of pairs for each piece of work: full ones of one segment each; what is left over of segments of about
  /// one length goes together. An inverse dynamics' motion is measured, each segment's its own.
  std::vector<std::vector<Pair>> packs_of(int count, std::span<const int> segments) const {
    const bool mixed = !std::holds_alternative<InverseDynamics>(experiment_.prediction);
    const int whole = mixed ? count - count % lanes() : count;
    std::vector<std::vector<Pair>> out;
    std::vector<Pair> left;
    for (const int s : segments) {
      for (int i = 0; i < whole; ++i) {
        if (i % lanes() == 0) out.emplace_back();
        out.back().push_back({i, s});
      }
      for (int i = whole; i < count; ++i) left.push_back({i, s});
    }
    const auto samples = [&](const Pair& p) { return experiment_.segments[p.segment].count; };
    std::ranges::stable_sort(left, {}, samples);
    for (std::size_t k = 0; k < left.size(); ++k) {
      if (k % static_cast<std::size_t>(lanes()) == 0) out.emplace_back();
      out.back().push_back(left[k]);
    }
    return out;
  }

  void run_on(Executor& executor, std::span<const std::vector<double>> individuals, std::span<const int> segments,
              const PredictionVisitor& visit, const PairResult& result) {
    const std::vector<std::vector<Pair>> packs = packs_of(static_cast<int>(individuals.size()), segments);
    const PieceWork simulate = [&](int worker, int piece) {
      const std::vector<Pair>& pack = packs[piece];
      std::vector<LaneTask> tasks;
      for (const auto& [individual, segment] : pack) {
        tasks.push_back({&individuals[individual], &experiment_.segments[segment]});
      }
      std::vector<std::vector<std::vector<double>>> predicted;
      workers_[worker]->predict(tasks, max_step_, predicted);
      for (std::size_t k = 0; k < pack.size(); ++k) visit(pack[k].individual, pack[k].segment, predicted[k]);
    };
    const PieceResults results = [&](int piece) {
      std::vector<std::span<std::byte>> out;
      for (const auto& [individual, segment] : packs[piece]) out.push_back(result(individual, segment));
      return out;
    };
    executor.run(static_cast<int>(packs.size()), simulate, results, key_of(individuals, segments));
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

using Predictions = std::vector<std::vector<double>>;  // by segment: channel by channel

Predictions predictions_at(double step, const PlantModel& model, const Experiment& experiment,
                           const SimulatorOptions& options, std::span<const double> values,
                           const std::vector<int>& segments) {
  SimulatorOptions with = options;
  with.max_step = step;
  Predictions out(experiment.segments.size());
  for (const int s : segments) {
    out[s].resize(experiment.channels.size() * experiment.segments[s].count);
  }
  const std::vector<std::vector<double>> one{std::vector<double>(values.begin(), values.end())};
  make_simulator(model, experiment, with)
      ->run(
          one, segments,
          [&](int, int s, const auto& predicted) {
            auto to = out[s].begin();
            for (const std::vector<double>& channel : predicted) to = std::copy(channel.begin(), channel.end(), to);
          },
          [&](int, int s) { return std::as_writable_bytes(std::span(out[s])); });
  return out;
}

/// rms of the difference over the channel's noise; of the segment and channel where that is largest.
double largest_change(const Predictions& coarse, const Predictions& fine, const Experiment& experiment,
                      const std::vector<int>& segments) {
  double worst = 0.0;
  for (const int s : segments) {
    for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
      const double noise = experiment.channels[c].noise;
      if (!(noise > 0.0)) continue;
      const std::size_t count = experiment.segments[s].count;
      const double* a = coarse[s].data() + c * count;
      const double* b = fine[s].data() + c * count;
      double sum = 0.0;
      for (std::size_t k = 0; k < count; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
      const double change = std::sqrt(sum / static_cast<double>(count)) / noise;
      worst = std::isfinite(change) ? std::max(worst, change) : HUGE_VAL;
    }
  }
  return worst;
}

}  // namespace

std::unique_ptr<Simulator> make_simulator(const PlantModel& model, const Experiment& experiment,
                                          const SimulatorOptions& options) {
  return std::make_unique<PopulationSimulator>(model, experiment, options);
}

LaneInfo lane_info() { return {lane_choice().name, lane_choice().width}; }

StepChoice choose_step(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options,
                       std::span<const double> values) {
  constexpr std::size_t kMostSegments = 12;  // windows: a dozen, spread evenly
  constexpr double kShare = 0.1;             // of the noise, the project's rule
  constexpr double kNoBetter = 2.0;          // error over the least one: no reason for ever shorter steps
  // Steps end at samples, so a step longer than the sampling period is none.
  const double coarsest = std::min(0.010, experiment.sample_period);
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return {coarsest, 0.0};
  // Of every recording, whatever its role: where a stiff mode rings at a step, one motion may hide it and the next not.
  const std::size_t all = experiment.segments.size(), every = (all + kMostSegments - 1) / kMostSegments;
  std::vector<int> segments;
  for (std::size_t s = 0; s < all; s += every) segments.push_back(static_cast<int>(s));
  const auto predict = [&](double step) { return predictions_at(step, model, experiment, options, values, segments); };

  std::vector<StepChoice> tried;
  int parts = 1;  // steps in the longest one
  for (Predictions coarse = predict(coarsest); tried.empty() || coarsest / parts >= kShortestStep; parts *= 2) {
    Predictions fine = predict(0.5 * coarsest / parts);
    const auto error = [&](const Predictions& at) {
      return kErrorOverChange * largest_change(at, fine, experiment, segments);
    };
    tried.push_back({coarsest / parts, error(coarse)});
    // Halving may have gone too far by almost two: the longest step in between that keeps to the rule.
    const double kept = tried.back().error_over_noise;
    for (int fewer = parts / 2 + 1; kept < kShare && fewer <= parts; ++fewer) {
      if (kept * std::pow(static_cast<double>(parts) / fewer, 4) >= kShare) continue;  // of fourth order
      const StepChoice longer{coarsest / fewer, fewer == parts ? kept : error(predict(coarsest / fewer))};
      if (longer.error_over_noise < kShare) return longer;
    }
    coarse = std::move(fine);
  }
  const double least = std::ranges::min(tried, {}, &StepChoice::error_over_noise).error_over_noise;
  return *std::ranges::find_if(tried, [&](const StepChoice& c) { return c.error_over_noise <= kNoBetter * least; });
}

}  // namespace lacuna
