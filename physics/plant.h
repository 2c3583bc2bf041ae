// A plant ready to run: actuators and effects around a rigid-body dynamics, over one scalar type.
//
// `Dyn` gives set_inertial(body, lane, Inertial), set_armature(joint, lane, value), set_gravity(lane, g),
// forward_dynamics(q, v, tau, free, a, imbalance) and inverse_dynamics(q, v, a, tau): Tree<T> (Featherstone, any lanes)
// or EngineDynamics (any engine, one lane).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "physics/actuators/table.h"
#include "physics/effects/table.h"
#include "physics/foundation.h"
#include "physics/plant_model.h"

namespace lacuna {

/// When a plant is asked for its efforts.
template <class T>
struct Instant {
  T t = T(0.0);                  ///< s, from the start of the session
  T since = T(0.0);              ///< s, since the start of the step, to which the memories belong
  const T* speeds = nullptr;     ///< rad/s (m/s), v of all joints
  T step = T(0.0);               ///< s, length of that step while its efforts are asked for; 0: none is on
  const T* positions = nullptr;  ///< rad (m), q of all joints
  T share = T(1.0);              ///< of what the joints' commands ask, what they get: by Plant::share()
  bool remembered = false;       ///< the memories are of this very instant: none is to be carried on to it
};

template <class T, class Dyn>
class Plant {
 public:
  Plant(const PlantModel& model, Dyn dynamics)
      : model_(&model),
        foundation_(std::move(dynamics), model.dof(), model.on_springs()),
        parameters_(model.parameters().size(), T(0.0)) {
    const std::size_t n = model.dof();
    joints_.resize(n);
    for (const Component& c : model.actuators()) {
      if (c.type < 0) continue;
      add(joints_[c.joint].actuator, c, Actuators::hooks<T>());
    }
    // In the catalogue's order, however the scenario lists them. What acts on the whole arm acts on each of its joints.
    for (int type = 0; type < static_cast<int>(Effects::hooks<T>().size()); ++type) {
      for (const Component& c : model.effects()) {
        if (c.type != type) continue;
        for (int j = 0; j < model.dof(); ++j) {
          if (c.joint < 0 || c.joint == j) add(joints_[j].effects, c, Effects::hooks<T>());
        }
      }
    }
    for (const Component& c : model.actuators()) {
      if (c.type >= 0) assign_roles(joints_[c.joint], c);
    }
    for (const Component& c : model.effects()) {
      const Hooks<T>& hooks = Effects::hooks<T>()[c.type];
      if (hooks.share != nullptr) asked_.resize(n), supply_ = {&hooks, static_cast<std::size_t>(c.first), 0, 0};
      if (hooks.base != nullptr) base_ = {&hooks, static_cast<std::size_t>(c.first), states_, memories_};
    }
    states_ += foundation_.states();
  }

  int dof() const { return model_->dof(); }
  int states() const { return states_; }
  int memories() const { return memories_; }
  Dyn& dynamics() { return foundation_.dynamics(); }
  /// s: components need not follow anything faster; 0 (at first): everything.
  void resolve(const T& time) { resolved_ = time; }

  /// Puts one parameter vector into one lane.
  void bind(int k, std::span<const double> values) {
    for (std::size_t i = 0; i < parameters_.size(); ++i) set_lane(parameters_[i], k, values[i]);
    for (const JointParts& parts : joints_) set_chambers(parts, k, values);
    for (const JointParts& parts : joints_)
      for (const Bound& c : parts.effects) c.known = false;
    const std::vector<Inertial> inertials = model_->inertials(values);
    for (int i = 0; i < dof(); ++i) foundation_.set_inertial(i, k, inertials[i]);
    const std::vector<double> armatures = model_->armatures(values);
    for (int i = 0; i < dof(); ++i) foundation_.set_armature(i, k, armatures[i]);
    foundation_.set_gravity(k, model_->gravity(values));
  }

  /// Changes one parameter while a motion lasts, until the next bind(): of a component whose efforts, commands or dry
  /// friction it enters. What bind() alone looks at (masses, armatures, chambers, gravity) stays.
  void vary(int parameter, const T& value) {
    parameters_[parameter] = value;
    for (const JointParts& parts : joints_)
      for (const Bound& c : parts.effects) c.known = false;
  }

  /// s, how late the command of joint j arrives; `delayed(j)` says whether any component delays it at all.
  bool delayed(int j) const {
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->delay != nullptr) return true;
    }
    return false;
  }
  T delay(int j) const {
    T sum(0.0);
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->delay != nullptr) sum = sum + c.hooks->delay(&parameters_[c.first]);
    }
    return sum;
  }

  /// Whether joint j's actuator may be faster than the steps; not behind a spring or a gap, whose own side it moves.
  bool is_fast(int j) const {
    return any_part(j, [](const Hooks<T>& h) { return h.fast != nullptr; }) &&
           !any_effect(j, [](const Hooks<T>& h) { return h.lead != nullptr; });
  }
  /// Whether joint j loses effort in proportion to its own speed; how much, N m s/rad (N s/m).
  bool is_lossy(int j) const {
    return any_part(j, [](const Hooks<T>& h) { return h.loss != nullptr; }) &&
           !any_effect(j, [](const Hooks<T>& h) { return h.lead != nullptr; });
  }
  T loss(int j) const {
    T sum(0.0);
    for (const std::vector<Bound>* parts : {&joint(j).actuator, &joint(j).effects}) {
      for (const Bound& c : *parts)
        if (c.hooks->loss != nullptr) sum = sum + c.hooks->loss(&parameters_[c.first]);
    }
    return sum;
  }
  bool has_chambers(int j) const { return joint(j).chambers; }
  /// Pa, in either chamber of joint j's actuator in states z; NaN where it has none.
  T pressure(int j, ChannelKind which, const T* z) const {
    if (!joint(j).chambers) return T(std::nan(""));
    return T(kPressureUnit) * z[actuator_state(j) + (which == ChannelKind::pressure_b ? 1 : 0)];
  }
  /// Puts a measured pressure (Pa; NaN: none was) in place of chamber `which` (0: A, 1: B) in states z.
  void set_pressure(int j, int which, const T& measured, T* z) const {
    if (!joint(j).chambers) return;
    T& state = z[actuator_state(j) + which];
    state = select(abs(measured) < T(1e300), measured / T(kPressureUnit), state);
  }
  /// Index of the actuator's first state among all of the plant's.
  int actuator_state(int j) const { return joint(j).actuator.front().state; }
  /// The fast part of joint j at `now`; arguments as of effort().
  FastPart<T> fast(int j, const Instant<T>& now, const T& q, const T& v, const T& u, const T* z, const T* m) const {
    JointView<T> s = view(joint(j), now, q, v, u);
    pass_command(j, now, m, nullptr, s);
    const Bound& c = joint(j).actuator.front();
    s.z = z + c.state;
    return c.hooks->fast(&parameters_[c.first], s);
  }
  /// Inertia of the arm at q, its base still, row by row: kg m^2 (kg m, kg).
  void mass_matrix(const T* q, T* mass) { foundation_.mass_matrix(q, mass); }

  /// Accelerations of the joints under efforts tau, as Tree::forward_dynamics; `z_rate` takes the rates of the base's
  /// states among all states z.
  void forward_dynamics(const T* q, const T* v, const T* tau, const T* free, const T* z, T* a, T* z_rate,
                        T* imbalance) {
    foundation_.forward_dynamics(q, v, tau, free, z + base_.state, a, z_rate + base_.state, imbalance);
  }
  /// Efforts that hold the joints still at q; `z_off` takes, of all states z, what of the base's is not at rest.
  void holding_efforts(const T* q, const T* z, T* holding, T* z_off) {
    foundation_.holding_efforts(q, z + base_.state, holding, z_off + base_.state);
  }
  /// Efforts for the motion (q, v, a), the base still.
  void inverse_dynamics(const T* q, const T* v, const T* a, T* tau) { foundation_.inverse_dynamics(q, v, a, tau); }

  /// Before efforts at `now` are asked for: what the joints' commands u (as they have arrived) get of what all share.
  /// `m` all memories at the start of the step.
  void share(Instant<T>& now, const T* q, const T* v, const T* u, const T* m) {
    if (asked_.empty()) return;
    for (int j = 0; j < dof(); ++j) {
      JointView<T> s = view(joint(j), now, q[j], v[j], u[j]);
      pass_command(j, now, m, nullptr, s, true);
      asked_[j] = s.u;
    }
    now.share = supply_.hooks->share(&parameters_[supply_.first], asked_.data(), dof());
  }

  /// Smooth effort on joint j at `now`; `u` the command that has arrived. `z` all states, `m` all memories at the start
  /// of the step; where not null, `z_rate` takes the states' rates and `m_now` the memories of joint j at this instant.
  T effort(int j, const Instant<T>& now, const T& q, const T& v, const T& u, const T* z, const T* m, T* z_rate,
           T* m_now) {
    JointView<T> s = view(joint(j), now, q, v, u);
    pass_command(j, now, m, m_now, s);
    return effort_of(j, now, s, z, m, z_rate, m_now);
  }
  /// What the command makes the actuator give.
  T driven_effort(int j, const Instant<T>& now, const T& q, const T& v, const T& u, const T* z, const T* m) {
    JointView<T> s = view(joint(j), now, q, v, u);
    pass_command(j, now, m, nullptr, s);
    const T whole = actuator_effort(joint(j), s, z, nullptr);
    s.u = T(0.0);
    return whole - actuator_effort(joint(j), s, z, nullptr);
  }
  /// What a drive that stores energy itself (an oil spring) gives by itself: it stands before the point at which
  /// efforts are measured. Losses and springs of other actuators stand behind it and are no part of this.
  T own_effort(int j, const Instant<T>& now, const T& q, const T& v, const T* z) {
    if (!stores_energy(j)) return T(0.0);
    return actuator_effort(joint(j), view(joint(j), now, q, v, T(0.0)), z, nullptr);
  }
  bool stores_energy(int j) const {
    return std::any_of(joint(j).actuator.begin(), joint(j).actuator.end(),
                       [](const Bound& c) { return c.hooks->states > 0; });
  }
  /// What the drive gives joint j, as a transducer of efforts has it: losses and springs behind it are no part.
  T drive_effort(int j, const Instant<T>& now, const T& q, const T& v, const T& u, const T* z, const T* m) {
    return driven_effort(j, now, q, v, u, z, m) + own_effort(j, now, q, v, z);
  }
  /// By how much the actuator's side leads the link under an effort that passes the transmission at rest, rad (m).
  T lead(int j, const T& effort) const {
    T sum(0.0);
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->lead != nullptr) sum = sum + c.hooks->lead(&parameters_[c.first], effort);
    }
    return sum;
  }
  /// Position of the actuator's side of joint j in states z; the link's own where no transmission lies between them.
  T drive_side(int j, const T& q, const T* z) const {
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->lead != nullptr) return z[c.state];
    }
    return q;
  }
  /// What acts on the link besides, loaded by nothing that a command brings. What a transmission carries is none of it:
  /// that is the drive's own effort on its way.
  T passive_effort(int j, const Instant<T>& now, const T& q, const T& v, const T* z, const T* m) {
    return effort_of(j, now, view(joint(j), now, q, v, T(0.0)), z, m, nullptr, nullptr, false);
  }

  bool has_dry_friction(int j) const {
    return any_effect(j, [](const Hooks<T>& h) { return h.dry_friction != nullptr; });
  }
  /// Whether joint j's friction depends on the effort that `effort` gave last.
  bool is_loaded(int j) const {
    return any_effect(j, [](const Hooks<T>& h) { return h.loaded; });
  }
  /// The friction that does (N m or N, along `direction` where it opposes the motion), where the joint is loaded by
  /// `given` beyond that effort. Looks at no command, state or memory.
  T loaded_friction(int j, const Instant<T>& now, const T& q, const T& v, const T& direction, const T& given) const {
    const JointParts& parts = joint(j);
    JointView<T> s = view(parts, now, q, v, T(0.0));
    s.load = parts.load + given, s.direction = direction;
    T sum(0.0);
    for (const Bound& c : parts.effects) {
      if (!c.hooks->loaded) continue;
      if (c.hooks->dry_friction != nullptr)
        sum = sum + direction * c.hooks->dry_friction(&parameters_[c.first], abs(v), s);
      if (c.hooks->effort != nullptr) sum = sum - c.hooks->effort(&parameters_[c.first], s);
    }
    return sum;
  }
  /// Whether joint j's dry friction differs with the direction.
  bool is_directed(int j) const {
    return any_effect(j, [](const Hooks<T>& h) { return h.directed; });
  }
  /// Magnitude of dry friction (N m or N) at sliding speed `speed` >= 0 in `direction` (-1, 1); at speed 0 the
  /// break-away effort under a pull that way.
  T dry_friction(int j, const Instant<T>& now, const T& q, const T& speed, const T& direction, const T& u) const {
    const JointParts& parts = joint(j);
    JointView<T> s = view(parts, now, q, speed, u);
    s.load = parts.load, s.direction = direction;
    T sum(0.0);
    for (const Bound& c : parts.effects) {
      if (c.hooks->dry_friction != nullptr) sum = sum + c.hooks->dry_friction(&parameters_[c.first], speed, s);
    }
    return sum;
  }

  /// Memories at the start of a simulation with component states z; without these nothing is held by friction.
  void begin_memories(const Instant<T>& now, const T* q, const T* v, const T* u, const T* z, T* m) {
    if (memories() == 0) return;
    std::vector<T> holding(dof());
    foundation_.holding_efforts(q, z ? z + base_.state : nullptr, holding.data(), nullptr);
    for (int j = 0; j < dof(); ++j) {
      const JointParts& parts = joint(j);
      JointView<T> s = view(parts, now, q[j], v[j], u[j]);
      s.share = T(1.0);  // lags, which stand before what is shared, begin here
      const T excess = z ? actuator_effort(parts, s, z, nullptr) - holding[j] : T(0.0);
      for (const Bound& c : parts.effects) {
        s.m = m + c.memory;
        if (c.hooks->begin != nullptr) c.hooks->begin(&parameters_[c.first], s, excess, m + c.memory);
        if (c.hooks->command != nullptr) s.u = passed(c, s);
      }
    }
  }

  /// Whether the command's way to joint j remembers anything (a lag, play).
  bool remembers_command(int j) const {
    return any_effect(j, [](const Hooks<T>& h) { return h.command != nullptr && h.memories > 0; });
  }
  /// Those memories of joint j after `dt` seconds under command u, none of it delayed; `begins`: as they begin under u.
  void pass_memories(int j, const Instant<T>& now, const T& q, const T& v, const T& u, const T& dt, bool begins,
                     T* m) const {
    JointView<T> s = view(joint(j), now, q, v, u);
    T scratch[kMostMemories];
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->command == nullptr) continue;
      if (c.hooks->share != nullptr) return;  // what remembers stands before it
      const T* p = &parameters_[c.first];
      if (c.hooks->memories > 0 && begins) c.hooks->begin(p, s, T(0.0), scratch);
      if (c.hooks->memories > 0 && !begins) c.hooks->remember(p, s, dt, m + c.memory, scratch);
      std::copy(scratch, scratch + c.hooks->memories, m + c.memory);
      s.m = m + c.memory;
      s.u = passed(c, s);
    }
  }

  /// What joint j's transducer makes of its positions at `time`, in place.
  void sense(int j, const std::vector<T>& time, T* q, std::size_t stride) const {
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->sense != nullptr) c.hooks->sense(&parameters_[c.first], time, q, stride);
    }
  }
  /// What joint j's transducer makes of its effort.
  T measured_effort(int j, const T& effort) const {
    T out = effort;
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->measure != nullptr) out = c.hooks->measure(&parameters_[c.first], out);
    }
    return out;
  }
  /// Position behind a reading at rest.
  T unsensed(int j, T q) const {
    const std::vector<Bound>& effects = joint(j).effects;
    for (auto c = effects.rbegin(); c != effects.rend(); ++c) {
      if (c->hooks->unsense != nullptr) q = c->hooks->unsense(&parameters_[c->first], q);
    }
    return q;
  }

  /// States at the start of a simulation at rest or in motion at (q, v) under commands u.
  void initial_states(const T* q, const T* v, const T* u, T* z) {
    if (states_ == 0) return;
    if (base_.hooks != nullptr)
      foundation_.begin(base_.hooks->base(&parameters_[base_.first]), resolved_, q, z + base_.state);
    std::vector<T> holding(dof());
    foundation_.holding_efforts(q, z + base_.state, holding.data(), nullptr);
    for (int j = 0; j < dof(); ++j) {
      const JointParts& parts = joint(j);
      JointView<T> s = view(parts, {}, q[j], v[j], u[j]);
      auto start = [&](const Bound& c) {
        if (c.hooks->initial == nullptr) return;
        c.hooks->initial(&parameters_[c.first], s, holding[j], z + c.state);
      };
      for (const Bound& c : parts.actuator) start(c);
      s.drive = actuator_effort(parts, s, z, nullptr);
      for (const Bound& c : parts.effects) start(c);
    }
  }

  /// Gain of joint j's actuator, used to express efforts in command units; 1 where it has none.
  T gain(int j) const {
    for (const Bound& c : joint(j).actuator) {
      if (c.hooks->strength != nullptr) return c.hooks->strength(&parameters_[c.first]);
    }
    return parameter_at(joint(j).roles.gain, 1.0);
  }

 private:
  struct Bound {
    const Hooks<T>* hooks;
    std::size_t first;  ///< parameters
    int state, memory;  ///< offsets of its states and memories
    // Of a curve that commands pass, its last value:
    mutable bool known = false;
    mutable T before = T(0.0), behind = T(0.0);  ///< V
  };
  struct JointParts {
    std::vector<Bound> actuator, effects;
    ActuatorRoles roles;  ///< as indices of all parameters
    T load = T(0.0);      ///< N m or N, on the joint as last asked for
    bool chambers = false;
    int count = 0;  ///< the actuator's parameters
  };

  void add(std::vector<Bound>& to, const Component& c, const std::vector<Hooks<T>>& table) {
    const Hooks<T>& hooks = table[c.type];
    to.push_back({&hooks, static_cast<std::size_t>(c.first), states_, memories_});
    states_ += hooks.states;
    memories_ += hooks.memories;
  }
  /// The actuator's own parameters in lane k as the joint's effects leave them.
  void set_chambers(const JointParts& parts, int k, std::span<const double> values) {
    if (!parts.chambers) return;
    const Bound& drive = parts.actuator.front();
    const std::span<const double> given = values.subspan(drive.first, static_cast<std::size_t>(parts.count));
    std::vector<double> own(given.begin(), given.end());
    for (const Bound& c : parts.effects)
      if (c.hooks->chambers != nullptr) c.hooks->chambers(&values[c.first], own.data());
    for (std::size_t i = 0; i < own.size(); ++i) set_lane(parameters_[drive.first + i], k, own[i]);
  }
  static void assign_roles(JointParts& parts, const Component& actuator) {
    const ActuatorInfo& info = actuator_table()[actuator.type];
    parts.roles = info.roles;
    parts.chambers = info.chambers;
    parts.count = actuator.count;
    for (int* role : {&parts.roles.gain, &parts.roles.damping, &parts.roles.stiffness, &parts.roles.rest}) {
      if (*role >= 0) *role += actuator.first;
    }
  }
  T parameter_at(int index, double otherwise) const { return index < 0 ? T(otherwise) : parameters_[index]; }

  const JointParts& joint(int j) const { return joints_[j]; }
  template <class Test>
  bool any_effect(int j, const Test& test) const {
    return std::any_of(joint(j).effects.begin(), joint(j).effects.end(),
                       [&](const Bound& c) { return test(*c.hooks); });
  }
  /// Of the actuator and the effects.
  template <class Test>
  bool any_part(int j, const Test& test) const {
    return any_effect(j, test) || std::any_of(joint(j).actuator.begin(), joint(j).actuator.end(),
                                              [&](const Bound& c) { return test(*c.hooks); });
  }
  JointView<T> view(const JointParts& parts, const Instant<T>& now, const T& q, const T& v, const T& u) const {
    JointView<T> s;
    s.t = now.t, s.q = q, s.v = v, s.u = u, s.speeds = now.speeds, s.positions = now.positions, s.joints = dof(),
    s.share = now.share, s.step = now.step, s.resolved = resolved_;
    s.actuator = parts.actuator.empty() ? nullptr : &parameters_[parts.actuator.front().first];
    s.damping = parameter_at(parts.roles.damping, 0.0), s.stiffness = parameter_at(parts.roles.stiffness, 0.0),
    s.rest = parameter_at(parts.roles.rest, 0.0);
    return s;
  }

  /// A component's memories at this instant, into `scratch` for its other hooks and into `m_now`.
  void recall(const Bound& c, const Instant<T>& now, const T* m, T* m_now, T* scratch, JointView<T>& s) const {
    if (c.hooks->remember == nullptr) return;
    if (now.remembered) {
      s.m = m + c.memory;
      return;
    }
    c.hooks->remember(&parameters_[c.first], s, now.since, m + c.memory, scratch);
    s.m = scratch;
    if (m_now == nullptr) return;
    for (int k = 0; k < c.hooks->memories; ++k) m_now[c.memory + k] = scratch[k];
  }

  /// The command through all effects that act on it, or those before what all joints share.
  void pass_command(int j, const Instant<T>& now, const T* m, T* m_now, JointView<T>& s, bool asks = false) const {
    T scratch[kMostMemories];
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->command == nullptr) continue;
      if (asks && c.hooks->share != nullptr) return;
      recall(c, now, m, m_now, scratch, s);
      s.u = passed(c, s);
    }
  }
  /// The command behind one of them. Commands are held between samples: a curve's value is looked up once for each.
  T passed(const Bound& c, const JointView<T>& s) const {
    if (!c.hooks->curve) return c.hooks->command(&parameters_[c.first], s);
    if (!c.known || any(c.before != s.u)) {
      c.before = s.u, c.behind = c.hooks->command(&parameters_[c.first], s);
      c.known = true;
    }
    return c.behind;
  }

  T actuator_effort(const JointParts& parts, JointView<T> s, const T* z, T* z_rate) const {
    T tau(0.0);
    for (const Bound& c : parts.actuator) {
      s.z = z + c.state;
      if (c.hooks->flow != nullptr) s.flow = taken_flow(parts, c, s);
      if (c.hooks->effort != nullptr) tau = tau + c.hooks->effort(&parameters_[c.first], s);
      if (c.hooks->rate != nullptr && z_rate != nullptr) c.hooks->rate(&parameters_[c.first], s, z_rate + c.state);
    }
    return tau;
  }
  /// rad/s (m/s), of what `drive` would bring by itself, what the joint's effects let it take up.
  T taken_flow(const JointParts& parts, const Bound& drive, const JointView<T>& s) const {
    T flow = drive.hooks->flow(&parameters_[drive.first], s);
    for (const Bound& c : parts.effects) {
      if (c.hooks->taken != nullptr) flow = c.hooks->taken(&parameters_[c.first], s, s.z[0], flow);
    }
    return flow;
  }

  T effort_of(int j, const Instant<T>& now, JointView<T> s, const T* z, const T* m, T* z_rate, T* m_now,
              bool carried = true) {
    JointParts& parts = joints_[j];
    T scratch[kMostMemories];
    T tau = actuator_effort(parts, s, z, z_rate);
    s.drive = tau;
    parts.load = s.load = tau + s.damping * s.v;
    for (const Bound& c : parts.effects) {
      s.z = z + c.state;
      if (c.hooks->command == nullptr) recall(c, now, m, m_now, scratch, s);
      const bool acts = c.hooks->effort != nullptr && (carried || c.hooks->lead == nullptr);
      if (acts) tau = tau + c.hooks->effort(&parameters_[c.first], s);
      if (c.hooks->rate != nullptr && z_rate != nullptr) c.hooks->rate(&parameters_[c.first], s, z_rate + c.state);
    }
    return tau;
  }

  const PlantModel* model_;
  Foundation<T, Dyn> foundation_;
  std::vector<T> parameters_;
  std::vector<JointParts> joints_;
  std::vector<T> asked_;  ///< V, per joint; empty where nothing is shared
  Bound supply_{};        ///< what all joints share
  Bound base_{};          ///< what sets the base on springs; its states are the foundation's
  int states_ = 0, memories_ = 0;
  T resolved_ = T(0.0);  ///< s
};

}  // namespace lacuna
