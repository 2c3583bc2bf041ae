// What a measured motion needs: efforts by inverse dynamics, component states and memories carried along it.
//
// The motion is measured and filtered (Segment::motion), which is flat over the motion's own band; what it needs passes
// the same filter as the efforts that it is compared with, once each, so that the corners of friction are rounded
// alike, and both are thinned alike. No measured signal is changed.
#pragma once

#include <cmath>
#include <vector>

#include "physics/chamber_balance.h"
#include "physics/experiment.h"
#include "physics/fast_motion.h"
#include "physics/filter.h"
#include "physics/plant.h"

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
  const std::vector<double>& value = segment.commands->value[joint];
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

template <class T, class Dyn>
class InverseDynamicsRun {
 public:
  InverseDynamicsRun(Plant<T, Dyn>& plant, const Segment& segment)
      : plant_(plant),
        segment_(segment),
        motion_(*segment.motion),
        n_(plant.dof()),
        fast_(n_, 2 * n_ + static_cast<std::size_t>(plant.states()) + 1) {
    for (std::vector<T>* each : {&q_, &v_, &a_, &u_, &tau_}) each->assign(n_, T(0.0));
    z_.assign(static_cast<std::size_t>(plant.states()) + 1, T(0.0));
    m_.assign(static_cast<std::size_t>(plant.memories()) + 1, T(0.0));
    for (int j = 0; j < plant.dof(); ++j)
      if (plant.is_fast(j) && !segment.is_pressed(static_cast<std::size_t>(j)))
        fast_.add_spring(j, 2 * n_ + static_cast<std::size_t>(plant.actuator_state(j)));
    if (segment.pressures) pressures_ = resampled(*segment.pressures, segment.commands->time, motion_.time);
  }

  /// [channel][compared sample]: an effort, the command that the actuator would need for it, or the actuator's side.
  void run(const std::vector<Channel>& channels, double cutoff_hz, std::vector<std::vector<T>>& out) {
    std::vector<std::vector<T>> whole(channels.size(), std::vector<T>(motion_.samples()));
    std::vector<std::vector<T>> given(channels.size());
    for (std::size_t c = 0; c < channels.size(); ++c)
      if (channels[c].kind == ChannelKind::command) given[c].resize(motion_.samples());
    for (std::size_t k = 0; k < motion_.samples(); ++k) {
      arrive(k);
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const int j = channels[c].joint;
        const T needed = needed_effort(j, channels[c].kind == ChannelKind::effort);
        whole[c][k] = needed;
        if (channels[c].kind == ChannelKind::command) given[c][k] = driven_effort(j);
        if (channels[c].kind == ChannelKind::effort) whole[c][k] = plant_.measured_effort(j, needed);
        if (channels[c].kind == ChannelKind::motor_position) whole[c][k] = q_[j] + plant_.lead(j, needed);
      }
    }
    filtered(channels, cutoff_hz, whole, given, out);
  }

  /// [joint][sample]: what drives a joint beyond what the motion needs, N m (N).
  void excess(std::vector<std::vector<T>>& out) {
    out.assign(n_, std::vector<T>(motion_.samples()));
    for (std::size_t k = 0; k < motion_.samples(); ++k) {
      arrive(k);
      for (std::size_t j = 0; j < n_; ++j) {
        const int joint = static_cast<int>(j);
        out[j][k] = driven_effort(joint) - needed_effort(joint, false);
      }
    }
  }

  /// One lane, joints that measured pressures drive (chamber_balance.h).
  void balance(std::vector<ChamberBalance>& out) {
    out.assign(n_, {});
    std::vector<T> rates(z_.size(), T(0.0)), faster = rates;
    for (std::size_t k = 0; k < motion_.samples(); ++k) {
      arrive(k);
      for (std::size_t j = 0; j < n_; ++j) {
        if (!segment_.is_pressed(j)) continue;
        const int joint = static_cast<int>(j), at = plant_.actuator_state(joint);
        const auto chambers = [&](const T& v, std::vector<T>& rate) {
          plant_.effort(joint, now_, q_[j], v, u_[j], z_.data(), m_.data(), rate.data(), nullptr);
        };
        chambers(v_[j], rates);
        chambers(v_[j] + T(1.0), faster);
        for (const std::size_t which : {0u, 1u}) {
          const std::size_t i = static_cast<std::size_t>(at) + which;
          const double per_speed = lane(rates[i] - faster[i], 0), rise = rise_of(j, which, k) / kPressureUnit;
          out[j].flow[which].push_back((lane(rates[i], 0) - rise) / per_speed);
          out[j].compression[which].push_back(rise / per_speed);
        }
        out[j].effort.push_back(lane(tau_[j], 0));
        out[j].excess.push_back(lane(driven_effort(joint) - needed_effort(joint, false), 0));
      }
    }
  }

 private:
  /// Pa/s at sample k, between its neighbours.
  double rise_of(std::size_t joint, std::size_t which, std::size_t k) const {
    const std::vector<double>& p = pressures_[joint][which];
    const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, p.size() - 1);
    return (p[after] - p[before]) / (motion_.time[after] - motion_.time[before]);
  }

  /// States are carried in steps no longer than this.
  static constexpr double kStateStep = 1e-3;  // s
  static constexpr double kResolvedSteps = 0.7;

  void read(std::size_t k) {
    for (std::size_t j = 0; j < n_; ++j) {
      q_[j] = T(motion_.q[j][k]), v_[j] = T(motion_.v[j][k]), a_[j] = T(motion_.a[j][k]);
      u_[j] = delayed_command(plant_, segment_, static_cast<int>(j), k);
    }
  }

  /// To sample k, states and memories with it.
  void arrive(std::size_t k) {
    sample_ = k;
    const T t(segment_.session + motion_.time[k]);
    if (k == 0) {
      read(0);
      now_ = {t, T(0.0), v_.data(), T(0.0), q_.data()};
      if (plant_.states() > 0) plant_.initial_states(q_.data(), v_.data(), u_.data(), z_.data());
      press(k);
      plant_.begin_memories(now_, q_.data(), v_.data(), u_.data(), nullptr, m_.data());
    } else {
      if (plant_.states() > 0) carry_states(k);
      press(k);
      read(k);
      now_ = {t, T(motion_.time[k] - motion_.time[k - 1]), v_.data(), T(0.0), q_.data()};
    }
    plant_.inverse_dynamics(q_.data(), v_.data(), a_.data(), tau_.data());
    share(now_);
    for (std::size_t j = 0; j < n_; ++j)
      plant_.effort(static_cast<int>(j), now_, q_[j], v_[j], u_[j], z_.data(), m_.data(), nullptr, m_.data());
    now_.since = T(0.0), now_.remembered = true;
    share(now_);
  }
  /// Chambers that drive their joints, which are never carried, as measured at sample k.
  void press(std::size_t k) {
    for (std::size_t j = 0; j < pressures_.size(); ++j)
      for (const std::size_t which : {0u, 1u})
        if (const std::vector<double>& measured = pressures_[j][which]; !measured.empty())
          plant_.set_pressure(static_cast<int>(j), static_cast<int>(which), T(measured[k]), z_.data());
  }
  void share(Instant<T>& now) { plant_.share(now, q_.data(), v_.data(), u_.data(), m_.data()); }

  /// From sample k - 1 to k along the straight line between both, commands held: by Kutta's steps, or those that carry
  /// what is faster by itself.
  void carry_states(std::size_t k) {
    const double dt = motion_.time[k] - motion_.time[k - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / kStateStep)));
    plant_.resolve(T(kResolvedSteps * dt / steps));
    for (int s = 0; s < steps; ++s) fast_.none() ? kutta_step(k, s, steps) : fast_step(k, s, steps);
  }

  /// Rates of the states z where the motion is `share` of the way from sample k - 1 to k.
  void rates(std::size_t k, double share, const T* z, T* out) {
    for (std::size_t j = 0; j < n_; ++j) {
      q_[j] = T(motion_.q[j][k - 1] + share * (motion_.q[j][k] - motion_.q[j][k - 1]));
      v_[j] = T(motion_.v[j][k - 1] + share * (motion_.v[j][k] - motion_.v[j][k - 1]));
    }
    const Instant<T> at = on_the_way(k, share);
    for (std::size_t j = 0; j < n_; ++j)
      plant_.effort(static_cast<int>(j), at, q_[j], v_[j], u_[j], z, m_.data(), out, nullptr);
    for (std::size_t j = 0; j < n_; ++j)
      if (segment_.is_pressed(j)) std::fill_n(out + plant_.actuator_state(static_cast<int>(j)), 2, T(0.0));
  }
  Instant<T> on_the_way(std::size_t k, double part) {
    const double dt = motion_.time[k] - motion_.time[k - 1];
    Instant<T> at{T(segment_.session + motion_.time[k - 1] + part * dt), T(0.0), v_.data(), T(0.0), q_.data()};
    share(at);
    return at;
  }

  void kutta_step(std::size_t k, int s, int steps) {
    const double h = (motion_.time[k] - motion_.time[k - 1]) / steps;
    const double begin = static_cast<double>(s) / steps, half = 0.5 / steps;
    std::vector<T> stage = z_, k1(z_.size()), k2 = k1, k3 = k1, k4 = k1;
    const auto moved = [&](const std::vector<T>& rate, double by) {
      for (std::size_t i = 0; i < z_.size(); ++i) stage[i] = z_[i] + T(by) * rate[i];
      return stage.data();
    };
    rates(k, begin, z_.data(), k1.data());
    rates(k, begin + half, moved(k1, 0.5 * h), k2.data());
    rates(k, begin + half, moved(k2, 0.5 * h), k3.data());
    rates(k, begin + 2.0 * half, moved(k3, h), k4.data());
    for (std::size_t i = 0; i < z_.size(); ++i) z_[i] = z_[i] + T(h / 6.0) * (k1[i] + T(2.0) * (k2[i] + k3[i]) + k4[i]);
  }

  /// The motion is given: no spring moves a joint (fast_ knows of no inertia), and only the states change.
  void fast_step(std::size_t k, int s, int steps) {
    const double h = (motion_.time[k] - motion_.time[k - 1]) / steps, begin = static_cast<double>(s) / steps;
    const std::size_t z = 2 * n_;
    std::vector<T> x(z + z_.size(), T(0.0)), k1 = x, k2 = x, k3 = x, k4 = x;
    std::copy(z_.begin(), z_.end(), x.begin() + static_cast<std::ptrdiff_t>(z));
    rates(k, begin, x.data() + z, k1.data() + z);
    for (auto& spring : fast_.springs()) {
      const std::size_t j = spring.joint;
      spring.part = plant_.fast(spring.joint, on_the_way(k, begin), q_[j], v_[j], u_[j], z_.data(), m_.data());
    }
    fast_.set_free(std::vector<T>(n_, T(1.0)));
    double share = begin + 0.5 / steps;  // k2 and k3 in the middle, k4 at the end
    fast_.step(x, T(h), k1, k2, k3, k4, x, [&](const T&, const std::vector<T>& at, std::vector<T>& out) {
      if (&out == &k4) share = begin + 1.0 / steps;
      rates(k, share, at.data() + z, out.data() + z);
    });
    std::copy(x.begin() + static_cast<std::ptrdiff_t>(z), x.end(), z_.begin());
  }

  T driven_effort(int j) { return plant_.driven_effort(j, now_, q_[j], v_[j], u_[j], z_.data(), m_.data()); }

  /// What the drive must give joint j; `all_of_it`: with what its actuator gives by itself, where that is no loss
  /// behind the point at which efforts are measured.
  T needed_effort(int j, bool all_of_it) {
    const T direction(motion_.direction[j][sample_]);
    const T passive = plant_.passive_effort(j, now_, q_[j], v_[j], z_.data(), m_.data());
    T needed = tau_[j] - passive + direction * plant_.dry_friction(j, now_, q_[j], abs(v_[j]), direction, u_[j]);
    if (plant_.is_loaded(j)) {  // friction may depend on the very effort that is sought
      const auto friction = [&](const T& effort) {
        return plant_.loaded_friction(j, now_, q_[j], v_[j], direction, effort);
      };
      const T others = needed - friction(T(0.0));
      needed = fixed_point<T>([&](const T& effort) { return others + friction(effort); });
    }
    return all_of_it ? needed + plant_.own_effort(j, now_, q_[j], v_[j], z_.data()) : needed;
  }

  /// Filters and thins. A command that would be needed is the one given and what is missing to it, in its own unit.
  void filtered(const std::vector<Channel>& channels, double cutoff_hz, std::vector<std::vector<T>>& whole,
                std::vector<std::vector<T>>& given, std::vector<std::vector<T>>& out) const {
    const ZeroPhaseLowPass filter(cutoff_hz, motion_.rate);
    out.assign(channels.size(), {});
    for (std::size_t c = 0; c < channels.size(); ++c) {
      std::vector<T>& signal = whole[c];
      if (channels[c].kind == ChannelKind::command) {
        for (std::size_t k = 0; k < signal.size(); ++k)
          signal[k] = (signal[k] - given[c][k]) / plant_.gain(channels[c].joint);
      }
      filter.apply(signal);
      out[c].reserve(segment_.compared.size());
      for (const std::size_t k : segment_.compared) out[c].push_back(signal[k]);
      if (channels[c].kind != ChannelKind::command) continue;
      for (std::size_t k = 0; k < out[c].size(); ++k) out[c][k] = out[c][k] + T(segment_.measured[c][k]);
    }
  }

  Plant<T, Dyn>& plant_;
  const Segment& segment_;
  const MeasuredMotion& motion_;
  std::size_t n_;
  FastMotion<T> fast_;
  PressureTrack pressures_;  ///< at the motion's samples; empty: no joint is driven by them
  std::vector<T> q_, v_, a_, u_, tau_, z_, m_;
  Instant<T> now_;
  std::size_t sample_ = 0;
};

}  // namespace lacuna
