// How an actuator or an effect acts on one joint: the few hooks a plant calls, each optional.
//
// A component is a struct with a static `info()` and the static member templates it needs, written over the scalar type
// T (`double` or a SIMD pack, backends/featherstone/scalar.h) and therefore branch-free: use select(), min(), max().
// `p` points at the component's parameters in the order of its info, `s.z` at its own states, `s.m` at its memories.
//
// States have rates and are integrated with the motion. Memories are carried from step to step in closed form: what
// play, bristles and first-order lags remember is known exactly, or to second order, at any instant within a step,
// however short their time is beside it.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "backends/featherstone/scalar.h"
#include "scenarios/robot.h"

namespace lacuna {

/// What a component may see of its joint at one instant.
template <class T>
struct JointView {
  T t = T(0.0);                 ///< s, from the start of the session: recordings follow one another
  T q = T(0.0), v = T(0.0);     ///< rad, rad/s (m, m/s)
  T u = T(0.0);                 ///< V, command as it reaches this component
  T step = T(0.0);              ///< s, length of the integration step within which this instant lies; 0: none is on
  T resolved = T(0.0);          ///< s, time of the fastest motion that the steps can follow; 0: any
  const T* actuator = nullptr;  ///< parameters of the joint's actuator
  const T* z = nullptr;         ///< the component's own states
  const T* m = nullptr;         ///< the component's own memories at this instant
  /// Of dry friction that is asked for: the way in which the joint slides, or at rest the way in which it is pulled; 0:
  /// neither.
  T direction = T(0.0);
  const T* speeds = nullptr;     ///< rad/s (m/s), v of all the arm's joints
  const T* positions = nullptr;  ///< rad (m), q of all of them
  int joints = 0;                ///< how many
  T share = T(1.0);              ///< of what its command asks, what the joint gets of what all share
  T flow = T(0.0);               ///< rad/s (m/s), what the actuator takes up of its own flow
  T drive = T(0.0);              ///< N m or N, the actuator's own effort at this instant (effects after the actuator)
  T load = T(0.0);               ///< N m or N, that effort without the actuator's damping: what loads the joint
  T damping = T(0.0), stiffness = T(0.0), rest = T(0.0);  ///< of the actuator; zero where its model has none
};

/// What optimisers see of a parameter: itself; its inverse, where the neutral value lies at infinity; its logarithm,
/// where only its order of magnitude is clear beforehand and it must stay positive.
enum class Coordinate { linear, inverse, logarithm };

inline double to_search(Coordinate coordinate, double value) {
  switch (coordinate) {
    case Coordinate::inverse: return 1.0 / value;
    case Coordinate::logarithm: return std::log(value);
    default: return value;
  }
}
inline double from_search(Coordinate coordinate, double x) {
  return coordinate == Coordinate::logarithm ? std::exp(x) : to_search(coordinate, x);
}

/// What a typical size of a parameter is measured in; the experiment supplies the value (ga/search_space.h).
enum class Scale {
  ratio,      ///< 1
  command,    ///< V
  effort,     ///< N m: gain times command
  time,       ///< 1 s
  span,       ///< s, length of a recording
  mass,       ///< kg, all moving links
  velocity,   ///< rad/s
  position,   ///< rad, rms about the mean
  reach,      ///< rad, half the range travelled, counted from its middle
  travel,     ///< rad, the range travelled
  wave,       ///< 1/rad, one period over the range travelled: searched no longer than that
  stiffness,  ///< N m/rad: effort over position
  damping,    ///< N m s/rad: effort over velocity
  drag,       ///< N m s^2/rad^2: effort over velocity squared
  hardening,  ///< N m/rad^3: effort over position cubed
  length,     ///< m, a tenth of the arm's stretched length: searched no further than that
  inertia     ///< kg m^2: of all that moves with the joint, about its axis, joints at zero
};

struct ParameterInfo {
  const char* name;
  const char* unit;
  double neutral;       ///< at this value the component does nothing (effects) or the default (actuators)
  double lower, upper;  ///< physical range
  const char* meaning;
  Scale scale = Scale::ratio;
  std::vector<double> starts = {};  ///< sizes to start a search from, in units of `scale`
  Coordinate coordinate = Coordinate::linear;
  bool optional = false;  ///< a refinement of the effect's shape: tried free, and fixed at its neutral value
  /// Of an effect on the whole arm: one for every joint ("flow_joint_1"), after all others in `p`.
  bool per_joint = false;
  /// Of a learned effect: one for each of its `knots` ("value_1"), after all others in `p`.
  bool per_knot = false;
  /// Says what the component is made of: one value in all lanes, never searched.
  bool structural = false;
  /// The parameter of the same component below which this one must not lie; null: none. Loading refuses what does.
  const char* at_least = nullptr;
  /// Units of `scale`: smaller than this it is no such thing (a stop that its drive pushes through is a spring).
  double least = 0.0;
  /// Of an actuator with chambers: says how they fill, nothing where their pressures are measured and drive the joint.
  bool fills = false;
};

/// How a joint's speed and an actuator's first two states drive each other about one instant, where that may be faster
/// than the steps (physics/fast_motion.h).
template <class T>
struct FastPart {
  std::array<T, 2> effort{};      ///< N m (N) on the joint per unit of either state
  std::array<T, 2> from_speed{};  ///< rate of either state per rad/s (m/s)
  std::array<T, 4> among{};       ///< 1/s, rates of the first, then of the second, per unit of either
};

/// What an arm's base stands on.
template <class T>
struct BaseSpring {
  T k = T(HUGE_VAL);  ///< N m/rad; infinity: the base stands still
  T I = T(0.0);       ///< kg m^2, of what tilts with the base
  T c = T(0.0);       ///< N m s/rad
};

/// The larger of two positive numbers with a rounded corner: 9 % above where they are equal, 0.05 % at 2 : 1.
template <class T>
T rounded_max(const T& a, const T& b) {
  const T top = max(max(a, b), T(1e-300)), x = a / top, y = b / top;
  const T x4 = x * x * x * x, y4 = y * y * y * y;
  return top * sqrt(sqrt(sqrt(x4 * x4 + y4 * y4)));
}

/// Hooks of one component for one scalar type; null where the component does not act.
template <class T>
struct Hooks {
  T (*command)(const T* p, const JointView<T>& s) = nullptr;  ///< V: s.u changed
  T (*effort)(const T* p, const JointView<T>& s) = nullptr;   ///< N m or N: smooth effort on the joint
  /// N m or N, >= 0: dry friction's magnitude at sliding speed `speed` >= 0; at speed 0 the break-away effort, in
  /// either case in the direction of s.direction.
  T (*dry_friction)(const T* p, const T& speed, const JointView<T>& s) = nullptr;
  T (*delay)(const T* p) = nullptr;  ///< s, of the command
  /// rad/s (m/s), what a drive that integrates its flow still takes up of `flow` when it has brought the joint's side
  /// of the oil to `oil` (rad, m).
  T (*taken)(const T* p, const JointView<T>& s, const T& oil, const T& flow) = nullptr;
  void (*rate)(const T* p, const JointView<T>& s, T* out) = nullptr;  ///< derivatives of the component's states
  /// States at the start: joint at q, v under command s.u, `holding` the effort that keeps it in place.
  void (*initial)(const T* p, const JointView<T>& s, const T& holding, T* out) = nullptr;
  int states = 0;
  /// Of an actuator whose first state is the position that its flow would give: that flow, rad/s (m/s). What is left of
  /// it its other hooks see as s.flow.
  T (*flow)(const T* p, const JointView<T>& s) = nullptr;
  T (*loss)(const T* p) = nullptr;  ///< N m s/rad (N s/m) of its effort that goes in proportion to speed
  // Of an actuator with two chambers, whose states are their pressures:
  FastPart<T> (*fast)(const T* p, const JointView<T>& s) = nullptr;
  T (*strength)(const T* p) = nullptr;  ///< N m/V (N/V), with the gain's sign: what it gives at most, over full command
  /// Memories at s from those `dt` seconds ago (`before`); the command has been constant in between. dt = 0 at the
  /// start of a step: then only what jumps with the command may change. Seen by this component's other hooks as s.m.
  /// Where s.step > 0 a memory that fades faster than the step is long may stand for its course over the step instead.
  void (*remember)(const T* p, const JointView<T>& s, const T& dt, const T* before, T* now) = nullptr;
  /// Memories at the start of a simulation; `excess`, N m or N: what the drive gives beyond what keeps the joint in
  /// place.
  void (*begin)(const T* p, const JointView<T>& s, const T& excess, T* now) = nullptr;
  int memories = 0;
  /// Of what all joints share: what each gets of what its command asks; `asked` V, of all `joints`, their commands as
  /// they reach it. `command` sees it as s.share.
  T (*share)(const T* p, const T* asked, int joints) = nullptr;
  bool curve = false;     ///< command looks at nothing but s.u
  bool loaded = false;    ///< dry_friction and effort look at s.load, and at no state or memory
  bool directed = false;  ///< dry_friction looks at s.direction
  /// What the joint's transducer makes of its position: changed in place at samples `time` (s), `stride` apart.
  void (*sense)(const T* p, const std::vector<T>& time, T* q, std::size_t stride) = nullptr;
  T (*unsense)(const T* p, const T& q) = nullptr;       ///< position behind a reading at rest
  T (*measure)(const T* p, const T& effort) = nullptr;  ///< N m or N: what the joint's transducer makes of its effort
  /// Of a transmission, whose first state is the actuator's side: by how much that leads the link at rest under an
  /// effort that passes, rad (m).
  T (*lead)(const T* p, const T& effort) = nullptr;
  BaseSpring<T> (*base)(const T* p) = nullptr;  ///< what the base stands on: of effects on the arm
  // One lane at a time, once for a simulation:
  /// Parameters of the joint's actuator as an effect leaves them, where that has chambers.
  void (*chambers)(const double* p, double* actuator) = nullptr;
  /// Mass properties changed, per body.
  void (*inertials)(const double* p, const Robot& robot, int joint, std::vector<Inertial>& bodies) = nullptr;
  double (*armature)(const double* p) = nullptr;                                        ///< kg m^2 (kg) at the joint
  Eigen::Vector3d (*gravity)(const double* p, const Eigen::Vector3d& plain) = nullptr;  ///< m/s^2, base frame
};

inline constexpr int kMostMemories = 2;  ///< of one component
inline constexpr int kMostKnots = 256;   ///< of one variable of a learned effect
inline constexpr int kMostBeside = 16;   ///< of its second variable
inline constexpr int kMostValues = 256;  ///< of a learned effect: the product of both

/// Fills the hooks that component C defines.
template <class C, class T>
Hooks<T> hooks_of() {
  Hooks<T> h;
  if constexpr (requires { &C::template command<T>; }) h.command = &C::template command<T>;
  if constexpr (requires { &C::template effort<T>; }) h.effort = &C::template effort<T>;
  if constexpr (requires { &C::template dry_friction<T>; }) h.dry_friction = &C::template dry_friction<T>;
  if constexpr (requires { &C::template delay<T>; }) h.delay = &C::template delay<T>;
  if constexpr (requires { &C::template rate<T>; }) h.rate = &C::template rate<T>;
  if constexpr (requires { &C::template loss<T>; }) h.loss = &C::template loss<T>;
  if constexpr (requires { &C::template fast<T>; }) h.fast = &C::template fast<T>;
  if constexpr (requires { &C::template strength<T>; }) h.strength = &C::template strength<T>;
  if constexpr (requires { &C::template initial<T>; }) h.initial = &C::template initial<T>;
  if constexpr (requires { &C::template remember<T>; }) h.remember = &C::template remember<T>;
  if constexpr (requires { &C::template begin<T>; }) h.begin = &C::template begin<T>;
  if constexpr (requires { &C::template taken<T>; }) h.taken = &C::template taken<T>;
  if constexpr (requires { &C::template flow<T>; }) h.flow = &C::template flow<T>;
  if constexpr (requires { C::states; }) h.states = C::states;
  if constexpr (requires { C::memories; }) h.memories = C::memories;
  if constexpr (requires { &C::template share<T>; }) h.share = &C::template share<T>;
  if constexpr (requires { C::curve; }) h.curve = C::curve;
  if constexpr (requires { C::loaded; }) h.loaded = C::loaded;
  if constexpr (requires { C::directed; }) h.directed = C::directed;
  if constexpr (requires { &C::template sense<T>; }) h.sense = &C::template sense<T>;
  if constexpr (requires { &C::template unsense<T>; }) h.unsense = &C::template unsense<T>;
  if constexpr (requires { &C::template measure<T>; }) h.measure = &C::template measure<T>;
  if constexpr (requires { &C::template lead<T>; }) h.lead = &C::template lead<T>;
  if constexpr (requires { &C::template base<T>; }) h.base = &C::template base<T>;
  if constexpr (requires { &C::chambers; }) h.chambers = &C::chambers;
  if constexpr (requires { &C::inertials; }) h.inertials = &C::inertials;
  if constexpr (requires { &C::armature; }) h.armature = &C::armature;
  if constexpr (requires { &C::gravity; }) h.gravity = &C::gravity;
  return h;
}

/// A table of components; `table.h` of actuators and of effects each name one.
template <class... C>
struct ComponentList {
  /// `info()` of each, in order.
  template <class Info>
  static std::vector<Info> infos() {
    return {C::info()...};
  }
  template <class T>
  static const std::vector<Hooks<T>>& hooks() {
    static const std::vector<Hooks<T>> table{hooks_of<C, T>()...};
    return table;
  }
};

}  // namespace lacuna
