// A plant ready to run: actuators and effects around a rigid-body dynamics, over one scalar type.
//
// `Dyn` gives set_inertial(body, lane, Inertial), set_gravity(lane, g), forward_dynamics(q, v, tau, free, a, imbalance)
// and inverse_dynamics(q, v, a, tau): Tree<T> (Featherstone, any lanes) or EngineDynamics (any engine, one lane).
#pragma once

#include <span>
#include <vector>

#include "physics/actuators/table.h"
#include "physics/effects/table.h"
#include "physics/plant_model.h"

namespace lacuna {

template <class T, class Dyn>
class Plant {
 public:
  Plant(const PlantModel& model, Dyn dynamics)
      : model_(&model), dynamics_(std::move(dynamics)), parameters_(model.parameters().size(), T(0.0)) {
    const std::size_t n = static_cast<std::size_t>(model.dof());
    joints_.resize(n);
    for (const Component& c : model.actuators()) {
      if (c.type < 0) continue;
      add(joints_[static_cast<std::size_t>(c.joint)].actuator, c, Actuators::hooks<T>());
    }
    // In the catalogue's order, however the scenario lists them.
    for (int type = 0; type < static_cast<int>(Effects::hooks<T>().size()); ++type) {
      for (const Component& c : model.effects()) {
        if (c.joint < 0 || c.type != type) continue;
        add(joints_[static_cast<std::size_t>(c.joint)].effects, c, Effects::hooks<T>());
      }
    }
  }

  int dof() const { return model_->dof(); }
  int states() const { return states_; }
  Dyn& dynamics() { return dynamics_; }

  /// Puts one parameter vector into one lane.
  void bind(int k, std::span<const double> values) {
    for (std::size_t i = 0; i < parameters_.size(); ++i) set_lane(parameters_[i], k, values[i]);
    const std::vector<Inertial> inertials = model_->inertials(values);
    for (int i = 0; i < dof(); ++i) dynamics_.set_inertial(i, k, inertials[static_cast<std::size_t>(i)]);
    dynamics_.set_gravity(k, model_->gravity());
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

  /// Smooth effort on joint j and the rates of its states; `u` the command that has arrived.
  T effort(int j, const T& t, const T& q, const T& v, const T& u, const T* z, T* z_rate) const {
    const JointParts& parts = joint(j);
    JointView<T> s = view(parts, t, q, v, u);
    for (const Bound& c : parts.effects) {
      if (c.hooks->command != nullptr) s.u = c.hooks->command(&parameters_[c.first], s);
    }
    T tau(0.0);
    auto collect = [&](const Bound& c) {
      s.z = z + c.state;
      if (c.hooks->effort != nullptr) tau = tau + c.hooks->effort(&parameters_[c.first], s);
      if (c.hooks->rate != nullptr && z_rate != nullptr) z_rate[c.state] = c.hooks->rate(&parameters_[c.first], s);
    };
    for (const Bound& c : parts.actuator) collect(c);
    for (const Bound& c : parts.effects) collect(c);
    return tau;
  }

  bool has_dry_friction(int j) const {
    for (const Bound& c : joint(j).effects) {
      if (c.hooks->dry_friction != nullptr) return true;
    }
    return false;
  }
  /// Magnitude of dry friction at sliding speed `speed` >= 0 (N m or N); at 0 the break-away effort.
  T dry_friction(int j, const T& t, const T& q, const T& speed, const T& u) const {
    const JointParts& parts = joint(j);
    const JointView<T> s = view(parts, t, q, speed, u);
    T sum(0.0);
    for (const Bound& c : parts.effects) {
      if (c.hooks->dry_friction != nullptr) sum = sum + c.hooks->dry_friction(&parameters_[c.first], speed, s);
    }
    return sum;
  }

  /// States at the start of a simulation at rest or in motion at (q, v) under commands u.
  void initial_states(const T* q, const T* v, const T* u, T* z) {
    if (states_ == 0) return;
    std::vector<T> holding(static_cast<std::size_t>(dof())), zero(holding.size(), T(0.0));
    dynamics_.inverse_dynamics(q, zero.data(), zero.data(), holding.data());
    for (int j = 0; j < dof(); ++j) {
      const std::size_t i = static_cast<std::size_t>(j);
      const JointParts& parts = joint(j);
      const JointView<T> s = view(parts, T(0.0), q[i], v[i], u[i]);
      auto start = [&](const Bound& c) {
        if (c.hooks->states() == 0) return;
        z[c.state] = c.hooks->initial != nullptr ? c.hooks->initial(&parameters_[c.first], s, holding[i]) : T(0.0);
      };
      for (const Bound& c : parts.actuator) start(c);
      for (const Bound& c : parts.effects) start(c);
    }
  }

  /// Effort per command of joint j's actuator (its first parameter), used to express efforts in command units.
  T gain(int j) const {
    const JointParts& parts = joint(j);
    return parts.actuator.empty() ? T(1.0) : parameters_[parts.actuator.front().first];
  }

 private:
  struct Bound {
    const Hooks<T>* hooks;
    std::size_t first;  ///< parameters
    int state;          ///< offset of its states
  };
  struct JointParts {
    std::vector<Bound> actuator, effects;
  };

  void add(std::vector<Bound>& to, const Component& c, const std::vector<Hooks<T>>& table) {
    const Hooks<T>& hooks = table[static_cast<std::size_t>(c.type)];
    to.push_back({&hooks, static_cast<std::size_t>(c.first), states_});
    states_ += hooks.states();
  }
  const JointParts& joint(int j) const { return joints_[static_cast<std::size_t>(j)]; }
  JointView<T> view(const JointParts& parts, const T& t, const T& q, const T& v, const T& u) const {
    const T* actuator = parts.actuator.empty() ? nullptr : &parameters_[parts.actuator.front().first];
    return {t, q, v, u, actuator, nullptr};
  }

  const PlantModel* model_;
  Dyn dynamics_;
  std::vector<T> parameters_;
  std::vector<JointParts> joints_;
  int states_ = 0;
};

}  // namespace lacuna
