// The predictor over one scalar type and one dynamics: rollouts, or inverse dynamics of the measured motion.
#pragma once

#include "physics/inverse_dynamics.h"
#include "physics/predictor.h"
#include "physics/rollout.h"

namespace lacuna {

template <class T, class Dyn>
class LanePredictor final : public Predictor {
 public:
  LanePredictor(const PlantModel& model, const Experiment& experiment, Dyn dynamics)
      : model_(model), experiment_(experiment), plant_(model, std::move(dynamics)), rollout_(plant_) {}

  int lanes() const override { return kLanes<T>; }

  void predict(std::span<const LaneTask> tasks, double max_step,
               std::vector<std::vector<std::vector<double>>>& out) override {
    const LaneSegments<T> segments = bind(tasks);
    if (std::holds_alternative<InverseDynamics>(experiment_.prediction)) {
      const double cutoff = std::get<InverseDynamics>(experiment_.prediction).cutoff_hz;
      InverseDynamicsRun<T, Dyn>(plant_, *segments.front()).run(experiment_.channels, cutoff, efforts_);
      const auto compared = [&](std::size_t) { return efforts_.front().size(); };
      take(tasks.size(), efforts_.size(), compared, out,
           [&](std::size_t c, std::size_t s) -> const T& { return efforts_[c][s]; });
      return;
    }
    const std::size_t channels = experiment_.channels.size();
    rollout_.run(segments, experiment_.channels, max_step, flat_);
    const auto samples = [&](std::size_t i) { return tasks[i].segment->count; };
    take(tasks.size(), channels, samples, out,
         [&](std::size_t c, std::size_t s) -> const T& { return flat_[s * channels + c]; });
    for (std::size_t k = 0; k < tasks.size(); ++k) add_slips(*tasks[k].segment, out[k]);
  }

  LinearMotion linearise(const LaneTask& task, double max_step, const std::vector<double>& effort_sizes) override {
    bind(std::span(&task, 1));
    return rollout_.linearise(*task.segment, max_step, effort_sizes);
  }

  void excess(std::span<const LaneTask> tasks, const LinearMotion& motion,
              std::vector<std::vector<std::vector<double>>>& out) override {
    bind(tasks);
    Segment along = *tasks.front().segment;
    along.motion = motion.between;
    InverseDynamicsRun<T, Dyn>(plant_, along).excess(efforts_);
    const auto intervals = [&](std::size_t) { return motion.intervals(); };
    take(tasks.size(), efforts_.size(), intervals, out,
         [&](std::size_t j, std::size_t k) -> const T& { return efforts_[j][k]; });
  }

 private:
  LaneSegments<T> bind(std::span<const LaneTask> tasks) {
    LaneSegments<T> segments;
    for (int k = 0; k < kLanes<T>; ++k) {  // idle lanes repeat the last task
      const LaneTask& task = tasks[std::min(static_cast<std::size_t>(k), tasks.size() - 1)];
      segments[k] = task.segment;
      plant_.bind(k, model_.values_in(task.segment->file, *task.values));
    }
    return segments;
  }
  /// What transducers read too much, as the segment's events say.
  void add_slips(const Segment& segment, std::vector<std::vector<double>>& predicted) const {
    if (!segment.slips) return;
    for (std::size_t c = 0; c < predicted.size(); ++c) {
      const Channel& channel = experiment_.channels[c];
      if (channel.kind != ChannelKind::position) continue;
      const std::vector<double>& slip = (*segment.slips)[channel.joint];
      for (std::size_t s = 0; s < segment.count; ++s) predicted[c][s] += slip[s];
    }
  }
  template <class Samples, class At>
  void take(std::size_t tasks, std::size_t channels, const Samples& samples,
            std::vector<std::vector<std::vector<double>>>& out, const At& at) const {
    out.resize(tasks);
    for (std::size_t i = 0; i < tasks; ++i) {
      out[i].resize(channels);
      for (std::size_t c = 0; c < channels; ++c) {
        out[i][c].resize(samples(i));
        for (std::size_t s = 0; s < out[i][c].size(); ++s) out[i][c][s] = lane(at(c, s), static_cast<int>(i));
      }
    }
  }

  const PlantModel& model_;
  const Experiment& experiment_;
  Plant<T, Dyn> plant_;
  Rollout<T, Dyn> rollout_;
  std::vector<T> flat_;
  std::vector<std::vector<T>> efforts_;
};

}  // namespace lacuna
