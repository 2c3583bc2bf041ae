// Definitions of rollout.h; included by it only.
#pragma once

#include <algorithm>
#include <cmath>

namespace lacuna {

template <class T, class Dyn>
Rollout<T, Dyn>::Rollout(Plant<T, Dyn>& plant)
    : plant_(plant),
      n_(plant.dof()),
      size_(2 * n_ + static_cast<std::size_t>(plant.states())),
      fast_(n_, size_),
      dry_(n_) {
  for (State* x : {&x_, &next_, &stage_, &k1_, &k2_, &k3_, &k4_}) x->assign(size_, T(0.0));
  for (std::vector<T>* w : {&u_, &tau_, &push_, &probe_, &imbalance_, &imbalance_at_start_, &imbalance_at_middle_,
                            &direction_, &hold_up_, &hold_down_}) {
    w->assign(n_, T(0.0));
  }
  mass_.assign(n_ * n_, T(0.0));
  for (std::size_t j = 0; j < n_; ++j) {
    const int joint = static_cast<int>(j);
    if (plant.is_fast(joint)) fast_.add_spring(joint, 2 * n_ + static_cast<std::size_t>(plant.actuator_state(joint)));
    if (plant.is_lossy(joint)) fast_.add_loss(joint);
  }
  rise_.assign(n_, {T(0.0), T(0.0)});
  memory_.assign(plant.memories(), T(0.0));
  free_.assign(n_, T(1.0));
  for (std::size_t j = 0; j < n_; ++j) {
    dry_[j] = plant_.has_dry_friction(static_cast<int>(j));
    any_dry_ = any_dry_ || dry_[j];
    if (plant_.delayed(static_cast<int>(j))) {
      cursors_.push_back({static_cast<int>(j), T(0.0), T(0.0), std::vector<std::size_t>(kLanes<T>)});
    }
  }
}

template <class T, class Dyn>
void Rollout<T, Dyn>::run(const LaneSegments<T>& segments, const std::vector<Channel>& channels, double max_step,
                          std::vector<T>& out) {
  segments_ = segments;
  out.resize(count() * channels.size());
  start(max_step);
  record(channels, 0, out);
  for (std::size_t k = 0; k + 1 < count(); ++k) {
    advance(k, max_step);
    record(channels, k + 1, out);
  }
  sense(channels, out);
}

/// value(segment) of every lane's segment.
template <class T, class Dyn>
template <class Value>
T Rollout<T, Dyn>::of_each(const Value& value) const {
  T out(0.0);
  for (int k = 0; k < kLanes<T>; ++k) set_lane(out, k, value(*segments_[k]));
  return out;
}

/// Samples of the longest lane.
template <class T, class Dyn>
std::size_t Rollout<T, Dyn>::count() const {
  return (*std::ranges::max_element(segments_, {}, [](const Segment* s) { return s->count; }))->count;
}

/// s, of each lane's sample, or its last one.
template <class T, class Dyn>
T Rollout<T, Dyn>::time(std::size_t sample) const {
  return of_each([&](const Segment& s) { return s.time(std::min(sample, s.count - 1)); });
}

template <class T, class Dyn>
void Rollout<T, Dyn>::start(double max_step) {
  if (count() > 1) cut(0, max_step);
  for (std::size_t j = 0; j < n_; ++j) {
    x_[j] = plant_.unsensed(static_cast<int>(j), of_each([&](const Segment& s) { return s.q0[j]; }));
    x_[n_ + j] = of_each([&](const Segment& s) { return s.v0[j]; });
    direction_[j] = dry_[j] ? sign(x_[n_ + j]) : T(0.0);
  }
  for (Cursor& cursor : cursors_) {
    cursor.late = plant_.delay(cursor.joint);
    std::fill(cursor.index.begin(), cursor.index.end(), std::size_t{0});
  }
  step_ = T(0.0);
  t_ = time(0);
  session_ = of_each([](const Segment& s) { return s.session; });
  fetch_commands(0);
  plant_.initial_states(x_.data(), x_.data() + n_, u_.data(), x_.data() + 2 * n_);
  for (std::size_t j = 0; j < n_; ++j) {
    for (const std::size_t which : {0u, 1u}) {
      const auto measured = [&](const Segment& s) {
        return s.pressures0.empty() ? std::nan("") : s.pressures0[j][which];
      };
      plant_.set_pressure(static_cast<int>(j), static_cast<int>(which), of_each(measured), x_.data() + 2 * n_);
    }
  }
  fetch_pressures(0);
  plant_.begin_memories(instant(T(0.0), x_), x_.data(), x_.data() + n_, u_.data(), x_.data() + 2 * n_, memory_.data());
  run_up();
}

/// A window begins in the middle of a recording: what the command's way remembers began with the commands before.
template <class T, class Dyn>
void Rollout<T, Dyn>::run_up() {
  if (std::ranges::all_of(segments_, [](const Segment* s) { return s->first == 0; })) return;
  for (std::size_t j = 0; j < n_; ++j) {
    if (plant_.remembers_command(static_cast<int>(j))) run_up(j);
  }
}

/// Samples of a window's track before it that it may remember.
template <class T, class Dyn>
std::size_t Rollout<T, Dyn>::samples_before(const Segment* s) {
  const auto begin = s->commands->time.begin(), at = begin + static_cast<std::ptrdiff_t>(s->first);
  return static_cast<std::size_t>(at - std::lower_bound(begin, at, *at - kRunUp));
}

/// A delay in the command's way shifts all that follows it: the memories at the window's start are those that the
/// commands until the delay before would have brought without it.
template <class T, class Dyn>
void Rollout<T, Dyn>::run_up(std::size_t j) {
  const int joint = static_cast<int>(j);
  std::array<std::size_t, static_cast<std::size_t>(kLanes<T>)> before{};  // samples of each lane's track
  std::ranges::transform(segments_, before.begin(), samples_before);
  const std::size_t most = *std::ranges::max_element(before);
  const T delay = plant_.delay(joint);
  const Instant<T> now = instant(T(0.0), x_);
  T u(0.0);
  for (std::size_t back = most; back > 0; --back) {
    T dt(0.0);
    for (int k = 0; k < kLanes<T>; ++k) {
      const Segment& s = *segments_[k];
      const std::size_t has = before[k], at = s.first - std::min(back, has);
      const std::vector<double>& time = s.commands->time;
      const double until = time[s.first] - lane(delay, k);
      const double end = back > has ? time[at] : time[at + 1];  // lanes with less before them wait
      if (back == most || time[at] <= until) set_lane(u, k, s.commands->value[j][at]);
      set_lane(dt, k, std::max(0.0, std::min(end, until) - time[at]));
    }
    const auto pass = [&](bool begins) {
      plant_.pass_memories(joint, now, x_[j], x_[n_ + j], u, dt, begins, memory_.data());
    };
    if (back == most) pass(true);
    pass(false);
  }
}

template <class T, class Dyn>
void Rollout<T, Dyn>::fetch_commands(std::size_t sample) {
  for (std::size_t j = 0; j < n_; ++j)
    u_[j] = of_each([&](const Segment& s) { return s.commands->value[j][s.first + std::min(sample, s.count - 1)]; });
  for (Cursor& cursor : cursors_) move_cursor(cursor);
}

/// What acts besides on the way from a sample to the next.
template <class T, class Dyn>
void Rollout<T, Dyn>::fetch_pushes(std::size_t sample) {
  push_ = probe_;
  if (std::ranges::none_of(segments_, [](const Segment* s) { return s->pushes != nullptr; })) return;
  for (std::size_t j = 0; j < n_; ++j)
    push_[j] = push_[j] + of_each([&](const Segment& s) {
                 return s.pushes && sample + 1 < s.count ? (*s.pushes)[j][sample] : 0.0;
               });
}

/// Chambers as measured at a sample, and how their pressures rise from there to the next.
template <class T, class Dyn>
void Rollout<T, Dyn>::fetch_pressures(std::size_t sample) {
  for (std::size_t j = 0; j < n_; ++j) {
    if (!segments_.front()->is_pressed(j)) continue;
    for (const std::size_t which : {0u, 1u}) {
      const auto after = [&](std::size_t ahead) {
        return of_each([&](const Segment& s) {
          return (*s.pressures)[j][which][s.first + std::min(sample + ahead, s.count - 1)];
        });
      };
      plant_.set_pressure(static_cast<int>(j), static_cast<int>(which), after(0), x_.data() + 2 * n_);
      const T interval = time(sample + 1) - time(sample);
      rise_[j][which] =
          select(interval > T(0.0), T(1.0 / kPressureUnit) * (after(1) - after(0)) / max(interval, T(1e-300)), T(0.0));
    }
  }
}

/// Puts in force the last command that has arrived by the lane's clock; before the track's start the first one holds.
template <class T, class Dyn>
void Rollout<T, Dyn>::move_cursor(Cursor& cursor) {
  for (int k = 0; k < kLanes<T>; ++k) {
    const CommandTrack& track = *segments_[k]->commands;
    const std::vector<double>&time = track.time, &value = track.value[cursor.joint];
    const double late = lane(cursor.late, k), now = lane(t_, k);
    std::size_t& i = cursor.index[k];
    while (i + 1 < time.size() && time[i + 1] + late <= now + 1e-12 * (1.0 + now)) ++i;
    set_lane(u_[cursor.joint], k, value[i]);
    set_lane(cursor.next_jump, k, i + 1 < time.size() ? time[i + 1] + late : HUGE_VAL);
  }
}

template <class T, class Dyn>
T Rollout<T, Dyn>::step_to_jump(const T& h) const {
  T out = h;
  for (const Cursor& cursor : cursors_) out = min(out, max(cursor.next_jump - t_, T(0.0)));
  return out;
}

/// How long each of the steps is that lead from a sample to the next (s); the plant resolves what they can follow.
template <class T, class Dyn>
T Rollout<T, Dyn>::cut(std::size_t sample, double max_step) {
  const T nominal = of_each([&](const Segment& s) {
    if (sample + 1 >= s.count) return max_step;
    const double whole = s.time(sample + 1) - s.time(sample);
    return whole / std::ceil(whole / max_step - 1e-9);
  });
  plant_.resolve(T(kResolvedSteps) * nominal);
  return nominal;
}

template <class T, class Dyn>
void Rollout<T, Dyn>::advance(std::size_t sample, double max_step) {
  const T nominal = cut(sample, max_step), end = time(sample + 1);
  t_ = time(sample);
  fetch_commands(sample);
  fetch_pushes(sample);
  fetch_pressures(sample);
  // Every event costs one more round; a lane with more of them than this goes on with plain steps.
  const T most = T(kEvents) * (end - t_) / nominal + T(63.5), close = T(1e-9) * nominal;
  std::vector<T> fraction(n_, T(2.0));
  for (int round = 0;; ++round) {
    const T left = end - t_;
    const Mask<T> active = left > close;
    if (!any(active)) break;
    T h = select(active, step_to_jump(min(nominal, left)), T(0.0));
    h = select(left - h < close, left, h);  // no crumbs
    h = select(active, max(h, min(left, T(kShortest) * nominal)), T(0.0));
    remember(T(0.0));
    step_ = h;
    decide_directions(active);
    look_at_fast_motion();
    take_step(h);
    const Mask<T> looks = T(static_cast<double>(round)) < most;
    if (any_dry_ && any(looks)) {
      const T first = select(looks, first_event(h, fraction), T(2.0));
      if (any(first < T(1.0))) {
        step_ = h = select(first < T(1.0), h * first, h);
        if (!memory_.empty()) derivative(T(0.0), x_, k1_);  // a memory's course depends on the step
        take_step(h);
        settle_events(first, fraction);
      }
    }
    x_ = next_;
    t_ = select(active, t_ + h, t_);
    remember(h);
    for (Cursor& cursor : cursors_) move_cursor(cursor);
  }
}

template <class T, class Dyn>
Instant<T> Rollout<T, Dyn>::instant(const T& since, const State& x) const {
  Instant<T> now{session_ + t_ + since, since, x.data() + n_, step_, x.data()};
  plant_.share(now, x.data(), x.data() + n_, u_.data(), memory_.data());
  return now;
}

/// Carries the memories over `since` seconds, to the present state.
template <class T, class Dyn>
void Rollout<T, Dyn>::remember(const T& since) {
  if (memory_.empty()) return;
  // t_ and x_ stand at the end already: the instant is now, the memories are `since` old.
  Instant<T> now = instant(T(0.0), x_);
  now.since = since;
  now.step = T(0.0);
  plant_.share(now, x_.data(), x_.data() + n_, u_.data(), memory_.data());
  for (std::size_t j = 0; j < n_; ++j) {
    plant_.effort(static_cast<int>(j), now, x_[j], x_[n_ + j], u_[j], x_.data() + 2 * n_, memory_.data(), nullptr,
                  memory_.data());
  }
}

/// Rates `since` seconds after the start of the step.
template <class T, class Dyn>
void Rollout<T, Dyn>::derivative(const T& since, const State& x, State& dx) {
  const Instant<T> now = instant(since, x);
  const T* q = x.data();
  const T* v = q + n_;
  for (std::size_t j = 0; j < n_; ++j) {
    const int joint = static_cast<int>(j);
    dx[j] = v[j];
    tau_[j] = plant_.effort(joint, now, q[j], v[j], u_[j], q + 2 * n_, memory_.data(), dx.data() + 2 * n_, nullptr) +
              push_[j];
    if (segments_.front()->is_pressed(j))
      std::ranges::copy(rise_[j], dx.data() + 2 * n_ + plant_.actuator_state(joint));
    if (!dry_[j]) continue;
    const T speed = max(v[j] * direction_[j], T(0.0));
    tau_[j] = tau_[j] - direction_[j] * plant_.dry_friction(joint, now, q[j], speed, direction_[j], u_[j]);
  }
  plant_.forward_dynamics(q, v, tau_.data(), free_.data(), q + 2 * n_, dx.data() + n_, dx.data() + 2 * n_,
                          imbalance_.data());
}

/// Break-away efforts of joint j at the present state, and whether it is held.
template <class T, class Dyn>
void Rollout<T, Dyn>::look_at_friction(std::size_t j) {
  const int joint = static_cast<int>(j);
  const Instant<T> now = instant(T(0.0), x_);
  if (plant_.is_loaded(joint)) {
    plant_.effort(joint, now, x_[j], x_[n_ + j], u_[j], x_.data() + 2 * n_, memory_.data(), nullptr, nullptr);
  }
  hold_up_[j] = plant_.dry_friction(joint, now, x_[j], T(0.0), T(1.0), u_[j]);
  hold_down_[j] =
      plant_.is_directed(joint) ? plant_.dry_friction(joint, now, x_[j], T(0.0), T(-1.0), u_[j]) : hold_up_[j];
  // Without friction the joint is as free as in the plain model; with friction it is held while it has no direction.
  const Mask<T> dry = frictional(j);
  const Mask<T> lost = dry && (direction_[j] == T(0.0)) && (x_[n_ + j] != T(0.0));
  direction_[j] = select(dry, select(lost, sign(x_[n_ + j]), direction_[j]), T(0.0));
  free_[j] = select(dry && (direction_[j] == T(0.0)), T(0.0), T(1.0));
}

/// k1 at the present state, with every joint that has come to rest either held or set sliding.
template <class T, class Dyn>
void Rollout<T, Dyn>::decide_directions(const Mask<T>& active) {
  if (any_dry_) {
    for (std::size_t j = 0; j < n_; ++j) {
      if (dry_[j]) look_at_friction(j);
    }
  }
  derivative(T(0.0), x_, k1_);
  if (!any_dry_) return;
  for (int round = 0; round < kDecisions; ++round) {
    bool changed = false;
    for (std::size_t j = 0; j < n_; ++j) {
      if (!dry_[j]) continue;
      const Mask<T> slips = active && (free_[j] == T(0.0)) && (abs(imbalance_[j]) > breakaway(j, imbalance_[j]));
      // Set free an instant ago, yet driven back by its neighbours: it stays held over this step.
      const Mask<T> backs = active && (free_[j] == T(1.0)) && frictional(j) && (x_[n_ + j] == T(0.0)) &&
                            (k1_[n_ + j] * direction_[j] < T(0.0));
      if (!any(slips || backs)) continue;
      const bool last = round + 1 == kDecisions;
      direction_[j] = select(backs, T(0.0), select(slips && Mask<T>(!last), sign(imbalance_[j]), direction_[j]));
      free_[j] = select(backs, T(0.0), select(slips && Mask<T>(!last), T(1.0), free_[j]));
      changed = changed || !last || any(backs);
    }
    if (!changed) break;
    derivative(T(0.0), x_, k1_);
  }
  imbalance_at_start_ = imbalance_;
}

/// The fast part of the rates at the present state, for the step that begins.
template <class T, class Dyn>
void Rollout<T, Dyn>::look_at_fast_motion() {
  if (fast_.none()) return;
  for (auto& loss : fast_.losses()) loss.size = plant_.loss(loss.joint);
  plant_.mass_matrix(x_.data(), mass_.data());
  fast_.set_inertia(mass_);
  const Instant<T> now = instant(T(0.0), x_);
  for (auto& spring : fast_.springs()) {
    const std::size_t j = spring.joint;
    if (segments_.front()->is_pressed(j)) {
      spring.part = {{T(0.0), T(0.0)}, {T(0.0), T(0.0)}, {T(0.0), T(0.0), T(0.0), T(0.0)}};
      continue;
    }
    spring.part = plant_.fast(spring.joint, now, x_[j], x_[n_ + j], u_[j], x_.data() + 2 * n_, memory_.data());
  }
  fast_.set_free(free_);
}

/// next_ = x_ after one step of h, from k1_.
template <class T, class Dyn>
void Rollout<T, Dyn>::take_step(const T& h) {
  if (fast_.none()) return kutta_step(h);
  bool middle = false;  // k2 is evaluated there, then k3
  fast_.step(x_, h, k1_, k2_, k3_, k4_, next_, [&](const T& since, const State& x, State& dx) {
    derivative(since, x, dx);
    if (any_dry_ && middle) imbalance_at_middle_ = imbalance_;
    middle = &dx == &k2_;
  });
}

/// The same where nothing is faster than the steps.
template <class T, class Dyn>
void Rollout<T, Dyn>::kutta_step(const T& h) {
  const T half = T(0.5) * h;
  for (std::size_t i = 0; i < size_; ++i) stage_[i] = x_[i] + half * k1_[i];
  derivative(half, stage_, k2_);
  for (std::size_t i = 0; i < size_; ++i) stage_[i] = x_[i] + half * k2_[i];
  derivative(half, stage_, k3_);
  if (any_dry_) imbalance_at_middle_ = imbalance_;
  for (std::size_t i = 0; i < size_; ++i) stage_[i] = x_[i] + h * k3_[i];
  derivative(h, stage_, k4_);
  const T sixth = h * T(1.0 / 6.0);
  for (std::size_t i = 0; i < size_; ++i) {
    next_[i] = x_[i] + sixth * (k1_[i] + T(2.0) * (k2_[i] + k3_[i]) + k4_[i]);
  }
}

/// Zero in (0, 1] of p0 + p1 s + p2 s^2 + p3 s^3, which is not negative at 0 and negative at 1: bracketed Newton.
template <class T>
T zero_crossing(const T& p0, const T& p1, const T& p2, const T& p3) {
  const T drop = T(0.0) - (p1 + p2 + p3);  // p(0) - p(1)
  T low(0.0), high(1.0);
  T s = select((p0 > T(0.0)) && (drop > T(0.0)), p0 / select(drop > T(0.0), drop, T(1.0)), T(0.5));
  for (int k = 0; k < 8; ++k) {
    const T value = p0 + s * (p1 + s * (p2 + s * p3));
    const T slope = p1 + s * (T(2.0) * p2 + s * (T(3.0) * p3));
    low = select(value >= T(0.0), s, low);
    high = select(value >= T(0.0), high, s);
    const T newton = s - value / select(slope == T(0.0), T(1.0), slope);
    // Once converged, newton is one of the bounds.
    s = select((newton >= low) && (newton <= high), newton, T(0.5) * (low + high));
  }
  return s;
}

/// Where in the step a sliding joint comes to rest: zero of the cubic through its speeds and accelerations at both
/// ends.
template <class T, class Dyn>
T Rollout<T, Dyn>::reversal(std::size_t j, const T& h) const {
  const T v0 = x_[n_ + j], v1 = next_[n_ + j], d = direction_[j];
  const Mask<T> reverses = frictional(j) && (v1 * d < T(0.0));
  if (!any(reverses)) return T(2.0);
  const T a0 = h * k1_[n_ + j], a1 = h * k4_[n_ + j], chord = v1 - v0;
  const T s = zero_crossing<T>(v0 * d, a0 * d, (T(3.0) * chord - T(2.0) * a0 - a1) * d, (a0 + a1 - T(2.0) * chord) * d);
  return select(reverses, s, T(2.0));
}

/// Where in the step the effort on a held joint passes the break-away effort: on the parabola through start, middle,
/// end.
template <class T, class Dyn>
T Rollout<T, Dyn>::release(std::size_t j) const {
  const T b = breakaway(j, imbalance_[j]);
  const Mask<T> slips = (free_[j] == T(0.0)) && (abs(imbalance_[j]) > b);
  if (!any(slips)) return T(2.0);
  const T side = sign(imbalance_[j]);
  const T p0 = max(b - imbalance_at_start_[j] * side, T(0.0));
  const T middle = b - imbalance_at_middle_[j] * side, end = b - imbalance_[j] * side;
  const T curvature = T(2.0) * (p0 + end - T(2.0) * middle);
  return select(slips, zero_crossing<T>(p0, end - p0 - curvature, curvature, T(0.0)), T(2.0));
}

/// Earliest event of any joint as a fraction of the step (2: none), and each joint's own.
template <class T, class Dyn>
T Rollout<T, Dyn>::first_event(const T& h, std::vector<T>& fraction) const {
  T first(2.0);
  for (std::size_t j = 0; j < n_; ++j) {
    if (!dry_[j]) continue;
    fraction[j] = max(min(reversal(j, h), release(j)), T(kShortest));
    first = min(first, fraction[j]);
  }
  return first;
}

/// After the step was cut at the first event: joints that came to rest there lose their direction, released ones gain
/// one.
template <class T, class Dyn>
void Rollout<T, Dyn>::settle_events(const T& first, const std::vector<T>& fraction) {
  for (std::size_t j = 0; j < n_; ++j) {
    if (!dry_[j]) continue;
    const Mask<T> happens = (first < T(1.0)) && (fraction[j] <= first * T(1.0 + 1e-9));
    const Mask<T> stops = happens && (free_[j] == T(1.0));
    next_[n_ + j] = select(stops, T(0.0), next_[n_ + j]);
    direction_[j] = select(stops, T(0.0), select(happens, sign(imbalance_[j]), direction_[j]));
  }
}

template <class T, class Dyn>
void Rollout<T, Dyn>::record(const std::vector<Channel>& channels, std::size_t sample, std::vector<T>& out) {
  step_ = T(0.0);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::size_t j = channels[c].joint;
    T& value = out[sample * channels.size() + c];
    switch (channels[c].kind) {
      case ChannelKind::velocity: value = x_[n_ + j]; break;
      case ChannelKind::effort:
        value = plant_.drive_effort(channels[c].joint, instant(T(0.0), x_), x_[j], x_[n_ + j], u_[j],
                                    x_.data() + 2 * n_, memory_.data());
        value = plant_.measured_effort(channels[c].joint, value);
        break;
      case ChannelKind::motor_position: value = plant_.drive_side(channels[c].joint, x_[j], x_.data() + 2 * n_); break;
      case ChannelKind::position: value = x_[j]; break;
      case ChannelKind::pressure_a:
      case ChannelKind::pressure_b:
        value = plant_.pressure(channels[c].joint, channels[c].kind, x_.data() + 2 * n_);
        break;
      case ChannelKind::command: value = T(std::nan(""));  // never a channel of a simulation: make_experiment
    }
  }
}

/// Positions as their transducers give them.
template <class T, class Dyn>
void Rollout<T, Dyn>::sense(const std::vector<Channel>& channels, std::vector<T>& out) const {
  std::vector<T> instants;
  for (std::size_t k = 0; k < count(); ++k) instants.push_back(time(k));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == ChannelKind::position) plant_.sense(channels[c].joint, instants, &out[c], channels.size());
  }
}

}  // namespace lacuna
