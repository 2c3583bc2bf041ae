// The only time loop: one plant, every lane a parameter set, a segment and a clock of its own.
//
// Between samples the command is held. Steps are Kutta's fourth-order ones of at most `max_step`, cut where a delayed
// command jumps; oil springs faster than that are carried through them by themselves (fast_motion.h). Dry friction is
// exact: each joint slides (direction fixed over a step) or sticks (the joint is held); a step in which a sliding joint
// would reverse, or the effort on a held one pass the break-away effort, is repeated up to that instant, and the
// direction is decided anew there. So the order of the method survives friction, no step is limited by its stiffness,
// and no instant of slip hangs on where steps happen to begin. Lanes keep their own clocks inside a sample interval; a
// lane's result does not depend on its neighbours.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "physics/experiment.h"
#include "physics/fast_motion.h"
#include "physics/linear_motion.h"
#include "physics/plant.h"

namespace lacuna {

/// What each lane is driven by and starts from. A lane whose segment has fewer samples waits at its last one.
template <class T>
using LaneSegments = std::array<const Segment*, static_cast<std::size_t>(kLanes<T>)>;

template <class T, class Dyn>
class Rollout {
 public:
  explicit Rollout(Plant<T, Dyn>& plant);

  /// Fills out[sample * channels.size() + channel]. A lane that diverges holds NaN or infinity from there on.
  void run(const LaneSegments<T>& segments, const std::vector<Channel>& channels, double max_step, std::vector<T>& out);

  /// The plant linearised along the motion on `segment`, every lane bound to the same parameters. Memories and joints
  /// that friction holds stay as they are in it. `effort_sizes`: [joint], N m (N), what counts as an effort there.
  LinearMotion linearise(const Segment& segment, double max_step, const std::vector<double>& effort_sizes);

 private:
  static constexpr double kRunUp = 20.0;     ///< s of commands before a window: four times the longest lag there is
  static constexpr double kEvents = 8.0;     ///< of friction in a step, usually
  static constexpr int kDecisions = 4;       ///< rounds of stick/slide decisions at one instant
  static constexpr double kShortest = 1e-6;  ///< shortest step, as a share of the nominal one: no event stops the clock

  /// Time of the fastest motion resolved, in steps, of which Kutta's method stands motions of time 1/2.8. Shorter steps
  /// resolve more, so that halving them shows what this leaves out.
  static constexpr double kResolvedSteps = 0.7;

  /// Of a difference that linearises, relative to the range of what is moved: events must not change sides.
  static constexpr double kDifference = 1e-5;

  using State = std::vector<T>;  ///< q, v, z one after the other
  /// What a motion goes on from at a sample.
  struct Waypoint {
    State x;
    std::vector<T> memory, direction;
  };

  std::size_t count() const;
  T time(std::size_t sample) const;
  std::vector<Waypoint> waypoints(double max_step);
  std::shared_ptr<const MeasuredMotion> between(const std::vector<Waypoint>& way) const;
  template <class Value>
  T of_each(const Value& value) const;
  void start(double max_step);
  void run_up();
  void run_up(std::size_t j);
  static std::size_t samples_before(const Segment* s);
  T cut(std::size_t sample, double max_step);
  void advance(std::size_t sample, double max_step);
  void fetch_commands(std::size_t sample);
  void fetch_pushes(std::size_t sample);
  void fetch_pressures(std::size_t sample);
  Instant<T> instant(const T& since, const State& x) const;
  void derivative(const T& since, const State& x, State& dx);
  void remember(const T& since);
  void decide_directions(const Mask<T>& active);
  void look_at_fast_motion();
  void take_step(const T& h);
  void kutta_step(const T& h);
  /// What friction withstands of `pull` (N m or N) on joint j at rest, N m or N, >= 0.
  T breakaway(std::size_t j, const T& pull) const { return select(pull < T(0.0), hold_down_[j], hold_up_[j]); }
  Mask<T> frictional(std::size_t j) const { return max(hold_up_[j], hold_down_[j]) > T(0.0); }
  void look_at_friction(std::size_t j);
  T reversal(std::size_t j, const T& h) const;
  T release(std::size_t j) const;
  T first_event(const T& h, std::vector<T>& fraction) const;
  void settle_events(const T& first, const std::vector<T>& fraction);
  T step_to_jump(const T& h) const;
  void sense(const std::vector<Channel>& channels, std::vector<T>& out) const;
  void record(const std::vector<Channel>& channels, std::size_t sample, std::vector<T>& out);

  Plant<T, Dyn>& plant_;
  std::size_t n_, size_;
  LaneSegments<T> segments_{};
  T step_ = T(0.0);     ///< s, that is being taken
  T t_ = T(0.0);        ///< s, each lane its own, from the recording's start
  T session_ = T(0.0);  ///< s, from the session's start to the recording's
  State x_, next_, stage_, k1_, k2_, k3_, k4_;
  FastMotion<T> fast_;
  std::vector<T> mass_;    ///< the arm's inertia, row by row
  std::vector<T> memory_;  ///< of the plant, at the start of the step
  std::vector<T> u_, tau_, free_, direction_;
  std::vector<T> push_, probe_;  ///< N m or N, on the joints besides: the segments' own with it, and what linearises
  std::vector<std::array<T, 2>> rise_;  ///< 1/s, of measured pressures that drive joints, in kPressureUnit
  std::vector<T> hold_up_, hold_down_;  ///< break-away efforts under pulls up and down, N m or N
  std::vector<T> imbalance_, imbalance_at_start_, imbalance_at_middle_;  ///< effort on held joints, N m or N
  std::vector<bool> dry_;                                                ///< joints with any dry friction component
  bool any_dry_ = false;

  /// Where the delayed command of one joint stands, lane by lane.
  struct Cursor {
    int joint;
    T late, next_jump;               ///< s
    std::vector<std::size_t> index;  ///< sample of the track now in force
  };
  std::vector<Cursor> cursors_;
  void move_cursor(Cursor& cursor);
};

}  // namespace lacuna

#include "physics/rollout_impl.h"
#include "physics/rollout_linearise_impl.h"
