#include "compare/runner.h"

#include <algorithm>
#include <cmath>

#include "backends/engine.h"
#include "physics/cpu_clock.h"
#include "physics/engine_dynamics.h"
#include "physics/rollout.h"
#include "physics/truth.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

using EnginePlant = Plant<double, EngineDynamics>;

/// Positions of all joints, then their speeds.
std::vector<Channel> state_channels(const Robot& robot) {
  std::vector<Channel> out;
  for (const ChannelKind kind : {ChannelKind::position, ChannelKind::velocity}) {
    for (int j = 0; j < robot.dof(); ++j) out.push_back({kind, j, "", 0.0, false});
  }
  return out;
}

/// One more sample from [position of every joint, speed of every joint].
template <class At>
void append_sample(std::size_t dof, const At& at, Trajectory& out) {
  out.q.emplace_back(dof);
  out.v.emplace_back(dof);
  for (std::size_t j = 0; j < dof; ++j) {
    out.q.back()[j] = at(j);
    out.v.back()[j] = at(dof + j);
  }
}

/// Runs phase after phase; `advance(phase, segment, out)` appends the segment's samples, its first one only where `out`
/// is empty.
template <class Advance>
void run_phases(const Motion& motion, Trajectory& out, const Advance& advance) {
  for (std::size_t p = 0; p < motion.phases.size(); ++p) {
    const Phase& phase = motion.phases[p];
    Segment segment = phase.segment;
    if (p > 0) {
      segment.q0 = out.q.back();
      segment.v0 =
          speeds_after_pickup(motion.model, motion.phases[p - 1].values, phase.values, out.q.back(), out.v.back());
    }
    advance(phase, segment, out);
  }
}

/// A plant under an engine's own steps: what drives the joints is held over each.
class NativeRun {
 public:
  NativeRun(EnginePlant& plant, std::string integrator)
      : plant_(plant),
        integrator_(std::move(integrator)),
        n_(plant.dof()),
        u_(n_),
        tau_(n_),
        z_(plant.states()),
        z_rate_(z_.size()),
        memory_(plant.memories()) {}

  void run(const Segment& segment, double max_step, Trajectory& out) {
    q_ = segment.q0;
    v_ = segment.v0;
    t_ = segment.time(0);
    session_ = segment.session;
    fetch_commands(segment);
    plant_.initial_states(q_.data(), v_.data(), u_.data(), z_.data());
    plant_.begin_memories(instant(0.0), q_.data(), v_.data(), u_.data(), z_.data(), memory_.data());
    if (out.q.empty()) record(out);
    for (std::size_t k = 0; k + 1 < segment.count; ++k) {
      const double begin = segment.time(k), interval = segment.time(k + 1) - begin;
      const int pieces = static_cast<int>(std::ceil(interval / max_step - 1e-9));
      for (int piece = 0; piece < pieces; ++piece) {
        t_ = begin + interval * piece / pieces;
        fetch_commands(segment);
        step(interval / pieces);
        ++out.steps;
      }
      t_ = segment.time(k + 1);
      record(out);
    }
  }

 private:
  Instant<double> instant(double since) {
    Instant<double> now{session_ + t_, since, v_.data(), 0.0, q_.data()};
    plant_.share(now, q_.data(), v_.data(), u_.data(), memory_.data());
    return now;
  }

  /// The last command that has arrived; before the track's start the first one holds.
  void fetch_commands(const Segment& segment) {
    const std::vector<double>& time = segment.commands->time;
    for (std::size_t j = 0; j < n_; ++j) {
      const double now = t_ - plant_.delay(static_cast<int>(j));
      const auto after = std::upper_bound(time.begin(), time.end(), now + 1e-12 * (1.0 + std::fabs(now)));
      u_[j] =
          segment.commands->value[j][after == time.begin() ? 0 : static_cast<std::size_t>(after - time.begin()) - 1];
    }
  }

  void step(double h) {
    efforts(0.0, memory_.data());  // memories jump with the command
    plant_.dynamics().engine().native_step(integrator_, q_, v_, tau_, h);
    for (std::size_t i = 0; i < z_.size(); ++i) z_[i] += h * z_rate_[i];
    t_ += h;
    if (!memory_.empty()) efforts(h, memory_.data());
  }

  void efforts(double since, double* memory_now) {
    const Instant<double> now = instant(since);
    for (std::size_t j = 0; j < n_; ++j) {
      tau_[j] = plant_.effort(static_cast<int>(j), now, q_[j], v_[j], u_[j], z_.data(), memory_.data(), z_rate_.data(),
                              memory_now);
    }
  }

  void record(Trajectory& out) {
    append_sample(
        n_, [&](std::size_t i) { return i < n_ ? q_[i] : v_[i - n_]; }, out);
  }

  EnginePlant& plant_;
  std::string integrator_;
  std::size_t n_;
  double session_ = 0.0;  ///< s, from the session's start to the recording's
  double t_ = 0.0;
  std::vector<double> q_, v_, u_, tau_, z_, z_rate_, memory_;
};

}  // namespace

struct Runner::Plants {
  Plants(const std::string& engine, const PlantModel& model)
      : plant(model, EngineDynamics(find_engine(engine).build(model.moving_robot(), model.gravity()))),
        rollout(plant),
        channels(state_channels(model.robot())) {}

  EnginePlant plant;
  Rollout<double, EngineDynamics> rollout;
  std::vector<Channel> channels;
  std::vector<double> samples;
};

std::vector<Method> methods_of(const std::string& engine) {
  std::vector<Method> out{{kCommonMethod, false}, {kAdaptiveMethod, false}};
  for (const std::string& name : find_engine(engine).info().native_integrators) out.push_back({name, true});
  return out;
}

Runner::Runner(std::string engine, const Motion& motion)
    : engine_(std::move(engine)), motion_(motion), plants_(std::make_unique<Plants>(engine_, motion.model)) {}
Runner::~Runner() = default;

void Runner::set_own_losses(std::span<const JointLoss> losses) {
  plants_->plant.dynamics().engine().set_own_losses(losses);
}

std::string Runner::refuses(const Method& method) const {
  if (!method.native) return "";
  for (int j = 0; j < motion_.model.dof(); ++j) {
    if (plants_->plant.has_dry_friction(j)) return "dry friction: an effort held over a step cannot hold a joint still";
  }
  if (motion_.model.on_springs())
    return "base compliance: its joints are added outside the engines, to be the same in all";
  for (const Phase& phase : motion_.phases) {
    const std::vector<double> armatures = motion_.model.armatures(phase.values);
    if (std::any_of(armatures.begin(), armatures.end(), [](double inertia) { return inertia != 0.0; }))
      return "armature: it is added outside the engines, to be the same in all";
  }
  return "";
}

Trajectory Runner::run(const Method& method, double step) {
  Trajectory out;
  Plants& p = *plants_;
  const double begun = thread_cpu_seconds();
  const std::size_t n = p.plant.dof();
  run_phases(motion_, out, [&](const Phase& phase, const Segment& segment, Trajectory& to) {
    p.plant.bind(0, phase.values);
    if (method.native) {
      NativeRun(p.plant, method.name).run(segment, step, to);
      return;
    }
    p.rollout.run({&segment}, p.channels, step, p.samples);
    for (std::size_t k = to.q.empty() ? 0 : 1; k < segment.count; ++k)
      append_sample(
          n, [&](std::size_t i) { return p.samples[k * 2 * n + i]; }, to);
    for (std::size_t k = 0; k + 1 < segment.count; ++k)
      to.steps += static_cast<long>(std::ceil((segment.time(k + 1) - segment.time(k)) / step - 1e-9));
  });
  out.seconds = thread_cpu_seconds() - begun;
  return out;
}

namespace {

/// All phases through simulate_truth.
Trajectory run_truth(const Motion& motion, TruthOptions options) {
  Trajectory out;
  const std::vector<Channel> channels = state_channels(motion.model.robot());
  const std::size_t n = channels.size() / 2;
  TruthEffort effort;
  options.effort = &effort;
  run_phases(motion, out, [&](const Phase& phase, const Segment& segment, Trajectory& to) {
    const auto states = simulate_truth(motion.model, segment, channels, phase.values, options);
    for (std::size_t k = to.q.empty() ? 0 : 1; k < segment.count; ++k)
      append_sample(
          n, [&](std::size_t i) { return states[i][k]; }, to);
    to.seconds += effort.seconds;
    to.steps += effort.evaluations;
  });
  return out;
}

}  // namespace

Trajectory Runner::run_adaptive(double tolerance, const StopFlag* stop) const {
  return run_truth(motion_, {.engine = engine_, .tolerance = tolerance, .settle = false, .outside = {}, .stop = stop});
}

Trajectory run_referee(const Motion& motion, double tolerance, double memory_step, const StopFlag* stop) {
  return run_truth(motion, {.tolerance = tolerance,
                            .memory_step = memory_step,
                            .settle = false,
                            .extended_precision = true,
                            .outside = {},
                            .stop = stop});
}

}  // namespace lacuna
