// The predictor over one scalar type and one dynamics: rollouts, or inverse dynamics of the measured motion.
#pragma once

#include <optional>

#include "physics/filter.h"
#include "physics/predictor.h"
#include "physics/rollout.h"

namespace lacuna {

/// The effort x = f(x) of a joint whose friction depends on it, from x = 0. f is a line on each side of a turn in the
/// load, where Steffensen's step is exact: two find the side and the point; the third is for a turn met on the way.
template <class T, class Function>
T fixed_point(const Function& f) {
  constexpr int kSteps = 3;
  T x(0.0);
  for (int step = 0; step < kSteps; ++step) {
    const T once = f(x), twice = f(once);
    const T change = once - x, bend = twice - once - change;
    x = select(abs(bend) > T(1e-12) * abs(change), x - change * change / bend, twice);
  }
  return x;
}

/// The command in force at a sample, delays taken off; before the track's start its first value.
template <class T, class Dyn>
T delayed_command(const Plant<T, Dyn>& plant, const Segment& segment, int joint, std::size_t sample) {
  const std::vector<double>& value = segment.commands->value[static_cast<std::size_t>(joint)];
  if (!plant.delayed(joint)) return T(value[segment.first + sample]);
  const std::vector<double>& time = segment.commands->time;
  const T delay = plant.delay(joint);
  T out(0.0);
  for (int k = 0; k < kLanes<T>; ++k) {
    const double at = time[segment.first + sample] - lane(delay, k) + 1e-12;
    const auto after = std::upper_bound(time.begin(), time.end(), at);
    set_lane(out, k, value[after == time.begin() ? 0 : static_cast<std::size_t>(after - time.begin()) - 1]);
  }
  return out;
}

/// Filtered position with its central differences; gaps are bridged by straight lines first.
inline void motion_of(const std::vector<double>& measured, double rate, const ZeroPhaseLowPass& filter,
                      std::vector<double>& q, std::vector<double>& v, std::vector<double>& a) {
  q = measured;
  const std::size_t n = q.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(q[i])) continue;
    std::size_t next = i;
    while (next < n && !std::isfinite(q[next])) ++next;
    const double left = i > 0 ? q[i - 1] : (next < n ? q[next] : 0.0), right = next < n ? q[next] : left;
    q[i] = left + (right - left) / static_cast<double>(next - i + 1);
  }
  filter.apply(q);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    v[i] = 0.5 * rate * (q[i + 1] - q[i - 1]);
    a[i] = rate * rate * (q[i + 1] - 2.0 * q[i] + q[i - 1]);
  }
  v.front() = v[1], v.back() = v[n - 2], a.front() = a[1], a.back() = a[n - 2];
}

/// The command that the model needs for the measured motion, less the command given: every signal passes the same
/// zero-phase filter (positions before differentiation, efforts of the command before comparison), then both sides pass
/// it once more and are thinned to twice the cutoff. The first and last half cycle of the cutoff are left out.
template <class T, class Dyn>
void predict_inverse_dynamics(Plant<T, Dyn>& plant, const Experiment& experiment, const Segment& segment,
                              std::vector<std::vector<T>>& out) {
  const double rate = 1.0 / experiment.sample_period;
  const double cutoff = std::get<InverseDynamics>(experiment.prediction).cutoff_hz;
  const ZeroPhaseLowPass filter(cutoff, rate);
  const std::size_t n = static_cast<std::size_t>(plant.dof()), samples = segment.count;
  std::vector<std::vector<double>> q(n, std::vector<double>(samples, 0.0)), v = q, a = q;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    if (experiment.channels[c].kind != ChannelKind::position) continue;
    const std::size_t j = static_cast<std::size_t>(experiment.channels[c].joint);
    motion_of(segment.measured[c], rate, filter, q[j], v[j], a[j]);
  }
  std::vector<std::vector<T>> given(n, std::vector<T>(samples)), needed = given;
  std::vector<T> qk(n), vk(n), ak(n), uk(n), tau(n), z(static_cast<std::size_t>(plant.states()) + 1, T(0.0));
  std::vector<T> m(static_cast<std::size_t>(plant.memories()) + 1, T(0.0));
  Instant<T> now;
  for (std::size_t k = 0; k < samples; ++k) {
    now = {T(segment.session + segment.time(k)), T(k == 0 ? 0.0 : segment.time(k) - segment.time(k - 1)), vk.data()};
    for (std::size_t j = 0; j < n; ++j) {
      qk[j] = T(q[j][k]), vk[j] = T(v[j][k]), ak[j] = T(a[j][k]);
      uk[j] = delayed_command(plant, segment, static_cast<int>(j), k);
    }
    if (k == 0) plant.begin_memories(now, qk.data(), vk.data(), uk.data(), nullptr, m.data());
    plant.inverse_dynamics(qk.data(), vk.data(), ak.data(), tau.data());
    for (std::size_t j = 0; j < n; ++j) {
      const int joint = static_cast<int>(j);
      plant.effort(joint, now, qk[j], vk[j], uk[j], z.data(), m.data(), nullptr, m.data());
      const Instant<T> here{now.t, T(0.0), now.speeds};  // the memories are of this sample by now
      given[j][k] = plant.driven_effort(joint, here, qk[j], vk[j], uk[j], z.data(), m.data());
      const auto behind = [&](const T& effort) {
        return tau[j] - plant.passive_effort(joint, here, qk[j], vk[j], z.data(), m.data(), effort) +
               sign(vk[j]) * plant.dry_friction(joint, here, qk[j], abs(vk[j]), sign(vk[j]), uk[j]);
      };
      // Friction may depend on the very effort that is sought.
      needed[j][k] = plant.is_loaded(joint) ? fixed_point<T>(behind) : behind(T(0.0));
    }
  }
  const Thinning thinning(cutoff, rate);
  out.assign(n, {});
  for (std::size_t j = 0; j < n; ++j) {
    filter.apply(given[j]);
    for (std::size_t k = 0; k < samples; ++k)
      needed[j][k] = (needed[j][k] - given[j][k]) / plant.gain(static_cast<int>(j));
    filter.apply(needed[j]);
    for (std::size_t k = thinning.edge; k + thinning.edge < samples; k += thinning.stride)
      out[j].push_back(needed[j][k]);
  }
}

template <class T, class Dyn>
class LanePredictor final : public Predictor {
 public:
  LanePredictor(const PlantModel& model, const Experiment& experiment, Dyn dynamics)
      : model_(model), experiment_(experiment), plant_(model, std::move(dynamics)), rollout_(plant_) {}

  int lanes() const override { return kLanes<T>; }

  void predict(std::span<const LaneTask> tasks, double max_step,
               std::vector<std::vector<std::vector<double>>>& out) override {
    LaneSegments<T> segments;
    for (int k = 0; k < kLanes<T>; ++k) {  // idle lanes repeat the last task
      const LaneTask& task = tasks[std::min(static_cast<std::size_t>(k), tasks.size() - 1)];
      segments[static_cast<std::size_t>(k)] = task.segment;
      plant_.bind(k, model_.values_in(task.segment->file, *task.values));
    }
    if (std::holds_alternative<InverseDynamics>(experiment_.prediction)) {
      predict_inverse_dynamics(plant_, experiment_, *segments.front(), efforts_);
      take(tasks.size(), efforts_.size(), efforts_.front().size(), out,
           [&](std::size_t c, std::size_t s) -> const T& { return efforts_[c][s]; });
      return;
    }
    const std::size_t channels = experiment_.channels.size();
    rollout_.run(segments, experiment_.channels, max_step, flat_);
    take(tasks.size(), channels, segments.front()->count, out,
         [&](std::size_t c, std::size_t s) -> const T& { return flat_[s * channels + c]; });
  }

 private:
  template <class At>
  void take(std::size_t tasks, std::size_t channels, std::size_t samples,
            std::vector<std::vector<std::vector<double>>>& out, const At& at) const {
    out.resize(tasks);
    for (std::size_t i = 0; i < tasks; ++i) {
      out[i].resize(channels);
      for (std::size_t c = 0; c < channels; ++c) {
        out[i][c].resize(samples);
        for (std::size_t s = 0; s < samples; ++s) out[i][c][s] = lane(at(c, s), static_cast<int>(i));
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
