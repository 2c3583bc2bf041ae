#include "physics/truth.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <numbers>

#include "backends/engine.h"
#include "backends/featherstone/tree.h"
#include "physics/cpu_clock.h"
#include "physics/engine_dynamics.h"
#include "physics/plant.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kDecisions = 4;  // rounds of stick/slide decisions at one instant

/// What a run is carried by: a scalar type, a dynamics over it, and a pair of methods with step control.
struct OnAnyEngine {
  using Scalar = double;
  using Dyn = EngineDynamics;
  using Stepper = boost::numeric::odeint::runge_kutta_dopri5<std::vector<double>>;
  static constexpr double order = 5.0;
  static constexpr double shortest = 1e-8;  ///< s, shortest step: no event and no kink stops the clock
  /// Of a sample interval: below it an engine's own rounding rules the error estimate.
  static constexpr double finest_share = 1e-3;
  static constexpr double close = 1e-12;  ///< s, relative: what is left of an interval that counts as nothing

  static Dyn dynamics(const PlantModel& model, const TruthOptions& options) {
    return EngineDynamics(find_engine(options.engine).build(model.moving_robot(), model.gravity()));
  }
};
struct InExtendedPrecision {
  using Scalar = long double;
  using Dyn = Tree<long double>;
  using Stepper = boost::numeric::odeint::runge_kutta_fehlberg78<std::vector<long double>, long double>;
  static constexpr double order = 8.0;
  static constexpr double shortest = 1e-13;
  static constexpr double finest_share = 1e-6;
  static constexpr double close = 1e-17;

  static Dyn dynamics(const PlantModel& model, const TruthOptions&) { return Tree<long double>(*model.moving_robot()); }
};

template <class By>
class TruthRun {
 public:
  using T = typename By::Scalar;
  using State = std::vector<T>;

  TruthRun(const PlantModel& model, const Segment& segment, std::span<const double> values, const TruthOptions& options)
      : plant_(model, By::dynamics(model, options)),
        segment_(segment),
        options_(options),
        values_(values.begin(), values.end()),
        n_(model.dof()),
        memory_(plant_.memories(), T(0.0)),
        u_(n_, T(0.0)),
        tau_(n_, T(0.0)),
        free_(n_, T(1.0)),
        direction_(n_, T(0.0)),
        hold_up_(n_, T(0.0)),
        hold_down_(n_, T(0.0)),
        imbalance_(n_, T(0.0)),
        rise_(n_, {T(0.0), T(0.0)}) {
    plant_.bind(0, values);
    x_.assign(2 * n_ + static_cast<std::size_t>(plant_.states()), T(0.0));
    rate_ = next_ = next_rate_ = error_ = x_;
    for (std::size_t j = 0; j < n_; ++j) dry_.push_back(plant_.has_dry_friction(static_cast<int>(j)));
    any_dry_ = std::find(dry_.begin(), dry_.end(), true) != dry_.end();
  }

  std::vector<std::vector<double>> run(const std::vector<Channel>& channels) {
    const double begun = thread_cpu_seconds();
    std::vector<std::vector<double>> out(channels.size());
    begin();
    record(channels, out);
    for (std::size_t k = 0; k + 1 < segment_.count; ++k) {
      if (options_.stop != nullptr && *options_.stop) throw Interrupted();
      interval_ = k;
      press();
      advance(segment_.time(k + 1), segment_.time(k + 1) - segment_.time(k));
      record(channels, out);
    }
    sense(channels, out);
    if (options_.effort != nullptr) {
      options_.effort->evaluations = evaluations_;
      options_.effort->seconds = thread_cpu_seconds() - begun;
    }
    return out;
  }

 private:
  void begin() {
    t_ = segment_.time(0);
    for (std::size_t j = 0; j < n_; ++j) {
      x_[j] = plant_.unsensed(static_cast<int>(j), T(segment_.q0[j]));
      x_[n_ + j] = T(segment_.v0[j]);
    }
    fetch_commands();
    const State start = x_;
    bool stands = !options_.settle;  // a closed cylinder holds wherever it stands
    for (std::size_t j = 0; j < n_; ++j) stands = stands || plant_.has_chambers(static_cast<int>(j));
    if (stands || !settle()) {
      x_ = start;
      plant_.initial_states(x_.data(), x_.data() + n_, u_.data(), x_.data() + 2 * n_);
    }
    for (std::size_t j = 0; j < segment_.pressures0.size(); ++j)
      for (const std::size_t which : {0u, 1u})
        plant_.set_pressure(static_cast<int>(j), static_cast<int>(which), T(segment_.pressures0[j][which]),
                            x_.data() + 2 * n_);
    press();
    plant_.begin_memories(instant(T(0.0), x_), x_.data(), x_.data() + n_, u_.data(), x_.data() + 2 * n_,
                          memory_.data());
  }

  /// Chambers that drive their joints: as measured at the interval's start, and how they rise from there.
  void press() {
    const double dt = segment_.time(interval_ + 1) - segment_.time(interval_);
    for (std::size_t j = 0; j < n_; ++j) {
      if (!segment_.is_pressed(j)) continue;
      for (const std::size_t which : {0u, 1u}) {
        const double* p = &(*segment_.pressures)[j][which][segment_.first + interval_];
        plant_.set_pressure(static_cast<int>(j), static_cast<int>(which), T(p[0]), x_.data() + 2 * n_);
        rise_[j][which] = T((p[1] - p[0]) / (kPressureUnit * dt));
      }
    }
  }

  /// What would move at rest at x: efforts that holding still asks for less those given, dry friction left out, then
  /// the rates of the states. The speeds in x are 0.
  Eigen::VectorXd unbalanced(const State& x) {
    const State zero(n_, T(0.0));
    State holding(n_), rates(x.size(), T(0.0));
    plant_.begin_memories(instant(T(0.0), x), x.data(), zero.data(), u_.data(), nullptr, memory_.data());
    plant_.holding_efforts(x.data(), x.data() + 2 * n_, holding.data(), rates.data() + 2 * n_);
    Eigen::VectorXd out(x.size() - n_);
    for (std::size_t j = 0; j < n_; ++j) {
      const int joint = static_cast<int>(j);
      const T given =
          outside_effort(j, x) + plant_.effort(joint, instant(T(0.0), x), x[j], T(0.0), u_[j], x.data() + 2 * n_,
                                               memory_.data(), rates.data() + 2 * n_, nullptr);
      out(j) = static_cast<double>(holding[j] - given);
    }
    for (std::size_t k = 2 * n_; k < x.size(); ++k) out(k - n_) = static_cast<double>(rates[k]);
    return out;
  }

  /// Newton's method over positions and states, from x_. False, x_ spoiled, where it leads nowhere near.
  bool settle() {
    constexpr double kNudge = 1e-6, kLongest = 0.3, kFarthest = std::numbers::pi, kClose = 1e-9;  // rad, m
    const State start = x_;
    std::fill_n(x_.begin() + static_cast<std::ptrdiff_t>(n_), n_, T(0.0));
    plant_.initial_states(x_.data(), x_.data() + n_, u_.data(), x_.data() + 2 * n_);
    const Eigen::Index size = x_.size() - n_;
    const auto place = [&](Eigen::Index k) {  // of unknown k in x_: the speeds are none
      return static_cast<std::size_t>(k) < n_ ? static_cast<std::size_t>(k) : static_cast<std::size_t>(k) + n_;
    };
    for (int round = 0; round < 60; ++round) {
      const Eigen::VectorXd off = unbalanced(x_);
      Eigen::MatrixXd slope(size, size);
      for (Eigen::Index k = 0; k < size; ++k) {
        State moved = x_;
        moved[place(k)] += kNudge;
        slope.col(k) = (unbalanced(moved) - off) / kNudge;
      }
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(slope);
      Eigen::VectorXd move = lu.solve(-off);
      if (!move.allFinite() || lu.rank() < size) return false;
      const double longest = move.cwiseAbs().maxCoeff();
      if (longest > kLongest) move *= kLongest / longest;
      for (Eigen::Index k = 0; k < size; ++k) x_[place(k)] += move(k);
      for (std::size_t j = 0; j < n_; ++j) {
        if (std::fabs(x_[j] - start[j]) > kFarthest) return false;
      }
      if (longest < kClose) return true;
    }
    return false;
  }

  Instant<T> instant(const T& since, const State& x) {
    for (const UnevenParameter& p : options_.uneven) {
      const std::size_t j = p.joint;
      const T phase = ((p.over_command ? u_[j] : x[j]) - T(p.centre)) / T(p.width);
      plant_.vary(p.parameter,
                  T(values_[p.parameter]) * (T(1.0) + T(p.share) * std::sin(T(2.0) * std::numbers::pi_v<T> * phase)));
    }
    Instant<T> now{T(segment_.session) + t_ + since, since, x.data() + n_, T(0.0), x.data()};
    plant_.share(now, x.data(), x.data() + n_, u_.data(), memory_.data());
    return now;
  }

  /// Commands in force now, and when the next one of them jumps within the sample interval.
  void fetch_commands() {
    const std::vector<double>& time = segment_.commands->time;
    next_jump_ = HUGE_VAL;
    for (std::size_t j = 0; j < n_; ++j) {
      const T late = plant_.delay(static_cast<int>(j));
      const auto after = std::upper_bound(time.begin(), time.end(), t_ - late + T(1e-12) * (T(1.0) + t_));
      const std::size_t i = after == time.begin() ? 0 : static_cast<std::size_t>(after - time.begin()) - 1;
      u_[j] = T(segment_.commands->value[j][i]);
      if (after != time.end()) next_jump_ = std::min(next_jump_, T(*after) + late);
      notch_command(j);
      drop_command(j);
    }
  }

  void notch_command(std::size_t j) {
    const T told = u_[j];
    for (const OutsidePhysics& outside : options_.outside)
      if (outside.kind == OutsidePhysics::Kind::valve_notch && outside.joint == static_cast<int>(j))
        u_[j] += outside_law(outside, told);
  }

  void drop_command(std::size_t j) {
    for (const OutsidePhysics& outside : options_.outside) {
      if (outside.kind != OutsidePhysics::Kind::command_dropout || outside.joint != static_cast<int>(j)) continue;
      for (const double from : times_of(outside)) {
        for (const double edge : {from, from + outside.strength})
          if (edge > t_ + 1e-12 * (1.0 + t_)) next_jump_ = std::min(next_jump_, T(edge));
        if (t_ + 1e-12 * (1.0 + t_) >= from && t_ < from + outside.strength) u_[j] = T(0.0);
      }
    }
  }

  std::vector<double> times_of(const OutsidePhysics& outside) const {
    const std::size_t recording = segment_.recording;
    return recording < outside.times.size() ? outside.times[recording] : std::vector<double>{};
  }

  T outside_effort(std::size_t j, const State& x, const T& since = T(0.0)) const {
    T sum(segment_.pushes ? (*segment_.pushes)[j][interval_] : 0.0);
    for (const OutsidePhysics& outside : options_.outside) {
      if (outside.joint != static_cast<int>(j) || info_of(outside.kind).stage != Stage::link) continue;
      const OutsideWay over = info_of(outside.kind).over;
      if (over == OutsideWay::time) sum += push(outside, since);
      if (over == OutsideWay::position) sum += outside_law(outside, x[j]);
      // Smooth about rest: the error estimate sees all of it, and there is no event to bisect.
      if (over == OutsideWay::position_and_direction)
        sum += outside_law(outside, x[j], T(std::tanh(x[n_ + j] / outside.form.slow)));
      if (over == OutsideWay::other_position) sum += outside_law(outside, x[outside.form.other]);
    }
    return sum;
  }

  T push(const OutsidePhysics& outside, const T& since) const {
    T sum(0.0);
    for (const double from : times_of(outside)) {
      const T phase = (t_ + since - from) / kPushLasts;
      if (phase > 0.0 && phase < 1.0) sum += outside.strength * std::sin(std::numbers::pi_v<T> * phase);
    }
    return sum;
  }

  void derivative(const T& since, const State& x, State& dx) {
    ++evaluations_;
    const T* q = x.data();
    const T* v = q + n_;
    const Instant<T> now = instant(since, x);
    for (std::size_t j = 0; j < n_; ++j) {
      const int joint = static_cast<int>(j);
      dx[j] = v[j];
      tau_[j] = outside_effort(j, x, since) +
                plant_.effort(joint, now, q[j], v[j], u_[j], q + 2 * n_, memory_.data(), dx.data() + 2 * n_, nullptr);
      if (segment_.is_pressed(j)) std::ranges::copy(rise_[j], dx.data() + 2 * n_ + plant_.actuator_state(joint));
      if (!dry_[j] || direction_[j] == 0.0) continue;
      const T speed = std::max(v[j] * direction_[j], T(0.0));
      tau_[j] -= direction_[j] * plant_.dry_friction(joint, now, q[j], speed, direction_[j], u_[j]);
    }
    plant_.forward_dynamics(q, v, tau_.data(), free_.data(), q + 2 * n_, dx.data() + n_, dx.data() + 2 * n_,
                            imbalance_.data());
  }

  /// Carries the memories over the `since` seconds that ended now.
  void remember(const T& since) {
    if (memory_.empty()) return;
    Instant<T> now = instant(T(0.0), x_);
    now.since = since;
    plant_.share(now, x_.data(), x_.data() + n_, u_.data(), memory_.data());
    for (std::size_t j = 0; j < n_; ++j)
      plant_.effort(static_cast<int>(j), now, x_[j], x_[n_ + j], u_[j], x_.data() + 2 * n_, memory_.data(), nullptr,
                    memory_.data());
  }

  /// What friction withstands of `pull` on joint j at rest.
  T breakaway(std::size_t j, const T& pull) const { return pull < 0.0 ? hold_down_[j] : hold_up_[j]; }
  bool frictional(std::size_t j) const { return dry_[j] && std::max(hold_up_[j], hold_down_[j]) > 0.0; }
  bool is_torn(std::size_t j) const { return std::fabs(imbalance_[j]) > breakaway(j, imbalance_[j]); }

  /// Break-away efforts now, and which joints are held.
  void look_at_friction() {
    for (std::size_t j = 0; j < n_; ++j) {
      if (!dry_[j]) continue;
      const int joint = static_cast<int>(j);
      plant_.effort(joint, instant(T(0.0), x_), x_[j], x_[n_ + j], u_[j], x_.data() + 2 * n_, memory_.data(), nullptr,
                    nullptr);
      hold_up_[j] = plant_.dry_friction(joint, instant(T(0.0), x_), x_[j], T(0.0), T(1.0), u_[j]);
      hold_down_[j] = plant_.dry_friction(joint, instant(T(0.0), x_), x_[j], T(0.0), T(-1.0), u_[j]);
      if (!frictional(j)) {
        direction_[j] = 0.0;
        free_[j] = 1.0;
        continue;
      }
      if (direction_[j] == 0.0 && x_[n_ + j] != 0.0) direction_[j] = x_[n_ + j] > 0.0 ? 1.0 : -1.0;
      free_[j] = direction_[j] == 0.0 ? 0.0 : 1.0;
    }
  }

  /// Rates now, after every joint at rest was either held or set sliding.
  void decide() {
    look_at_friction();
    derivative(T(0.0), x_, rate_);
    for (int round = 0; round < kDecisions; ++round) {
      bool changed = false;
      for (std::size_t j = 0; j < n_; ++j) {
        if (!frictional(j)) continue;
        if (free_[j] == 0.0 && is_torn(j) && round + 1 < kDecisions) {
          direction_[j] = imbalance_[j] > 0.0 ? 1.0 : -1.0;
          free_[j] = 1.0;
          changed = true;
        } else if (free_[j] == 1.0 && x_[n_ + j] == 0.0 && rate_[n_ + j] * direction_[j] < 0.0) {
          direction_[j] = free_[j] = 0.0;  // set free, yet driven back by its neighbours: it stays
          changed = true;
        }
      }
      if (!changed) return;
      derivative(T(0.0), x_, rate_);
    }
  }

  /// One step of h into next_; the largest error over tolerance.
  double try_step(const T& h) {
    const auto rates = [this](const State& x, State& dx, T since) { derivative(since, x, dx); };
    if constexpr (std::is_same_v<By, OnAnyEngine>) {  // this pair's last stage is the step's end
      stepper_.do_step(rates, x_, rate_, T(0.0), next_, next_rate_, h, error_);
    } else {
      stepper_.do_step(rates, x_, rate_, T(0.0), next_, h, error_);
      if (any_dry_) derivative(h, next_, next_rate_);  // has_event asks for the imbalance at the end
    }
    double worst = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const T size = std::max(std::fabs(x_[i]), std::fabs(next_[i]));
      worst = std::max(worst, static_cast<double>(std::fabs(error_[i]) / (options_.tolerance * (T(1.0) + size))));
    }
    return std::isfinite(worst) ? worst : HUGE_VAL;
  }

  /// Whether in the step just tried a sliding joint reversed or a held one was torn loose (`held` at its start).
  bool has_event(std::size_t j, const std::vector<bool>& held) const {
    if (!frictional(j)) return false;
    if (free_[j] == 0.0) return held[j] && is_torn(j);
    return next_[n_ + j] * direction_[j] < 0.0;
  }
  bool any_event(const std::vector<bool>& held) const {
    for (std::size_t j = 0; j < n_; ++j) {
      if (has_event(j, held)) return true;
    }
    return false;
  }

  /// Shortens the step just tried to its first event, and settles that.
  T stop_at_event(const T& h, const std::vector<bool>& held) {
    T before(0.0), after = h;
    while (after - before > By::shortest) {
      const T middle = T(0.5) * (before + after);
      try_step(middle);
      (any_event(held) ? after : before) = middle;
    }
    after = std::max(after, std::min(T(By::shortest), h));
    try_step(after);
    for (std::size_t j = 0; j < n_; ++j) {
      if (!has_event(j, held)) continue;
      const bool stops = free_[j] == 1.0;
      direction_[j] = T(stops ? 0.0 : (imbalance_[j] > 0.0 ? 1.0 : -1.0));
      if (stops) next_[n_ + j] = T(0.0);
    }
    return after;
  }

  void advance(double end, double interval) {
    const double close = By::close * (1.0 + end), finest = By::finest_share * interval;
    while (end - t_ > close) {
      fetch_commands();
      remember(T(0.0));
      decide();
      std::vector<bool> held;
      for (std::size_t j = 0; j < n_; ++j) held.push_back(!is_torn(j));
      T left = std::min(T(end), next_jump_) - t_;
      if (!memory_.empty()) left = std::min(left, T(options_.memory_step));
      T h = std::min(left, T(step_ > 0.0 ? step_ : 0.25 * interval));
      double error = try_step(h);
      for (; error > 1.0 && h > finest; error = try_step(h))
        h = std::max(T(finest), h * T(std::clamp(0.9 * std::pow(error, -1.0 / By::order), 0.2, 0.9)));
      h = std::min(h, left);
      step_ = std::max(finest, static_cast<double>(h) *
                                   std::clamp(0.9 * std::pow(std::max(error, 1e-10), -1.0 / By::order), 0.2, 5.0));
      if (any_event(held)) h = stop_at_event(h, held);
      x_ = next_;
      t_ = T(end) - t_ - h < close ? T(end) : t_ + h;
      remember(h);
    }
    t_ = end;
    fetch_commands();
    const bool finite = std::all_of(x_.begin(), x_.end(), [](const T& value) { return std::fabs(value) < 1e6; });
    if (!finite)
      throw WorkError("the motion diverges " + std::to_string(static_cast<double>(t_)) + " s after its start");
  }

  void record(const std::vector<Channel>& channels, std::vector<std::vector<double>>& out) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const std::size_t j = channels[c].joint;
      T value = x_[j];
      if (channels[c].kind == ChannelKind::velocity) value = x_[n_ + j];
      if (channels[c].kind == ChannelKind::motor_position)
        value = plant_.drive_side(channels[c].joint, x_[j], x_.data() + 2 * n_);
      if (channels[c].kind == ChannelKind::pressure_a || channels[c].kind == ChannelKind::pressure_b)
        value = plant_.pressure(channels[c].joint, channels[c].kind, x_.data() + 2 * n_);
      if (channels[c].kind == ChannelKind::effort)
        value = plant_.measured_effort(
            channels[c].joint, plant_.drive_effort(channels[c].joint, instant(T(0.0), x_), x_[j], x_[n_ + j], u_[j],
                                                   x_.data() + 2 * n_, memory_.data()));
      out[c].push_back(static_cast<double>(value));
    }
  }

  void sense(const std::vector<Channel>& channels, std::vector<std::vector<double>>& out) const {
    std::vector<T> time;
    for (std::size_t k = 0; k < segment_.count; ++k) time.push_back(T(segment_.time(k)));
    for (std::size_t c = 0; c < channels.size(); ++c)
      if (channels[c].kind == ChannelKind::position) {
        std::vector<T> readings(out[c].begin(), out[c].end());
        plant_.sense(channels[c].joint, time, readings.data(), 1);
        std::transform(readings.begin(), readings.end(), out[c].begin(),
                       [](const T& value) { return static_cast<double>(value); });
        if (!segment_.slips) continue;
        const std::vector<double>& slip = (*segment_.slips)[channels[c].joint];
        for (std::size_t k = 0; k < slip.size(); ++k) out[c][k] += slip[k];
      }
  }

  Plant<T, typename By::Dyn> plant_;
  const Segment& segment_;
  const TruthOptions& options_;
  std::vector<double> values_;
  std::size_t n_;
  T t_ = T(0.0), next_jump_ = T(HUGE_VAL);     // s
  double step_ = 0.0;                          // s, the next one to try
  State x_, rate_, next_, next_rate_, error_;  // q, v, z one after the other
  std::vector<T> memory_, u_, tau_, free_, direction_;
  std::vector<T> hold_up_, hold_down_, imbalance_;  // N m or N: break-away efforts under pulls up and down
  std::vector<std::array<T, 2>> rise_;              // 1/s, of measured pressures that drive joints, in kPressureUnit
  std::vector<bool> dry_;
  bool any_dry_ = false;
  long evaluations_ = 0;
  std::size_t interval_ = 0;  ///< between samples, that is simulated
  typename By::Stepper stepper_;
};

}  // namespace

std::vector<std::vector<double>> simulate_truth(const PlantModel& model, const Segment& segment,
                                                const std::vector<Channel>& channels, std::span<const double> values,
                                                const TruthOptions& options) {
  if (options.extended_precision) {
    return TruthRun<InExtendedPrecision>(model, segment, values, options).run(channels);
  }
  return TruthRun<OnAnyEngine>(model, segment, values, options).run(channels);
}

}  // namespace lacuna
