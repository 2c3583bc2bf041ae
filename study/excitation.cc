#include "study/excitation.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "ga/enum_names.h"
#include "ga/pagmo_optimizers.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 3> kShapes = {"multisine", "staircase", "both"};
constexpr double kWeakened = 0.8;  // a motion beyond its limits is weakened to this share, at most so often:
constexpr int kWeakenings = 16;
constexpr int kBisections = 12;

class Designer {
 public:
  Designer(const Trial& trial, const MotionLimits& limits) : trial_(trial), limits_(limits) {
    if (trial.scenario.pressure_driven)
      throw InputError(trial.scenario.file.string() + ": prediction", "pressure_driven", "joints that commands drive");
    const std::size_t n = trial.model->dof();
    const auto commands = trial.scenario.channels.of.find(ChannelKind::command);
    for (std::size_t j = 0; j < n; ++j) {
      const bool driven = commands != trial.scenario.channels.of.end() &&
                          commands->second.count(trial.experiment.joint_names[j]) > 0 && limits.command[j] > 0.0;
      if (driven) driven_.push_back(j);
    }
    if (driven_.empty())
      throw InputError(trial.scenario.file.string() + ": channels.command", "no joint with a command above 0 V",
                       "at least one, or --command");
    if (std::holds_alternative<InverseDynamics>(trial.scenario.prediction))
      throw InputError(trial.scenario.file.string() + ": prediction", "inverse_dynamics", "positions to be compared");
    rest_ = rest_position(trial, trial.model->values());
  }

  const std::vector<std::size_t>& driven() const { return driven_; }

  SeenMotion move(const Experiment& experiment) const {
    SimulatorOptions options;
    options.max_step = trial_.step.step;
    SeenMotion out;
    const std::vector<std::vector<double>> one{trial_.model->values()};
    const std::vector<int> segments{0};
    make_simulator(*trial_.model, experiment, options)->run(one, segments, [&](int, int, const auto& predicted) {
      out = seen_motion(experiment, experiment.segments.front(), predicted, limits_);
    });
    return out;
  }

  Design assessed(const std::string& name, const CommandTrack& commands) const {
    const Experiment experiment = commanded(trial_.experiment, commands, rest_);
    const SeenMotion motion = move(experiment);
    Design out{name, commands, 0.0, {}, {}, motion.speed, motion.lowest, motion.highest};
    for (const auto& column : commands.value) {
      double peak = 0.0;
      for (const double u : column) peak = std::max(peak, std::fabs(u));
      out.peak_command.push_back(peak);
    }
    const Task task = task_of(experiment);
    out.log_det = log_det(sensitivities(task, trial_.start));
    out.excitation = assess(task, trial_.start, name, false);
    return out;
  }

  /// The commands weakened together until the motion keeps to its limits; nothing where they would all but vanish.
  std::optional<CommandTrack> kept_within_limits(CommandTrack commands) const {
    for (int k = 0; k < kWeakenings; ++k) {
      const SeenMotion motion = move(commanded(trial_.experiment, commands, rest_));
      if (motion.finite && motion.beyond == 0.0) return commands;
      for (auto& column : commands.value) {
        for (double& u : column) u *= kWeakened;
      }
    }
    return std::nullopt;
  }

  /// Minus the information; infinite where it cannot be had.
  double cost(const CommandTrack& commands) const {
    const double found = log_det(sensitivities(task_of(commanded(trial_.experiment, commands, rest_)), trial_.start));
    return std::isfinite(found) ? -found : HUGE_VAL;
  }

  /// One step of all driven joints, as large as the limits allow.
  CommandTrack largest_step(double seconds) const {
    const auto at = [&](double share) {
      std::vector<double> volts(limits_.command.size(), 0.0);
      for (const std::size_t j : driven_) volts[j] = share * limits_.command[j];
      return step_commands(trial_, volts, seconds);
    };
    const auto keeps = [&](double share) {
      const SeenMotion motion = move(commanded(trial_.experiment, at(share), rest_));
      return motion.finite && motion.beyond == 0.0;
    };
    if (keeps(1.0)) return at(1.0);
    double low = 0.0, high = 1.0;
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (low + high);
      (keeps(middle) ? low : high) = middle;
    }
    if (low == 0.0) throw WorkError("no step of the commands keeps to the limits of position and speed");
    return at(low);
  }

 private:
  Task task_of(const Experiment& experiment) const {
    Task task = make_task(trial_, experiment, std::nullopt, "featherstone", nullptr);
    task.weights = trial_.weights;
    return task;
  }

  double log_det(const Eigen::MatrixXd& jacobian) const {
    const Eigen::MatrixXd scaled = jacobian * bound_deviations(trial_).asDiagonal();
    const Eigen::MatrixXd information =
        scaled.transpose() * scaled + Eigen::MatrixXd::Identity(jacobian.cols(), jacobian.cols());
    return 2.0 * information.llt().matrixL().toDenseMatrix().diagonal().array().log().sum();
  }

  const Trial& trial_;
  const MotionLimits& limits_;
  std::vector<std::size_t> driven_;
  std::vector<double> rest_;  ///< where every motion starts
};

CommandTrack track_of(const Trial& trial, const MotionLimits& limits, const Designer& designer, const Courses& courses,
                      double seconds, std::span<const double> point) {
  CommandTrack out = still_commands(limits.command.size(), seconds, trial.experiment.sample_period);
  for (std::size_t k = 0; k < designer.driven().size(); ++k) {
    const std::size_t j = designer.driven()[k];
    out.value[j] = courses.course(point.subspan(k * courses.size(), courses.size()), out.time, limits.command[j]);
  }
  return out;
}

CommandTrack own_commands(const Segment& segment) {
  CommandTrack out;
  for (std::size_t k = 0; k < segment.count; ++k) out.time.push_back(segment.time(k) - segment.time(0));
  for (const auto& column : segment.commands->value) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(segment.first);
    out.value.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(segment.count));
  }
  return out;
}

}  // namespace

const char* to_string(Shape shape) { return kShapes[static_cast<std::size_t>(shape)]; }
Shape shape_from_name(const std::string& name) { return enum_from_name<Shape>("--shape", kShapes, name); }

MotionLimits motion_limits(const Trial& trial, double command, double reach, double speed) {
  MotionLimits out = recorded_limits(trial.model->robot(), trial.experiment);
  const Segment& first = trial.experiment.segments[trial.experiment.with_role(Role::train).front()];
  for (std::size_t j = 0; j < out.command.size(); ++j) {
    if (!std::isnan(command)) out.command[j] = command;
    if (!std::isnan(reach)) {
      out.lowest[j] = std::max(out.lowest[j], first.q0[j] - reach);
      out.highest[j] = std::min(out.highest[j], first.q0[j] + reach);
    }
    if (!std::isnan(speed)) out.speed[j] = std::min(out.speed[j], speed);
  }
  return out;
}

DesignResult design_excitation(const Trial& trial, const MotionLimits& limits, const DesignOptions& options) {
  const Designer designer(trial, limits);
  const Courses courses(options.shape, options.seconds, options.hertz);
  const std::size_t size = courses.size() * designer.driven().size();
  const Box box{std::vector<double>(size, 0.0), std::vector<double>(size, 1.0), {}};
  const BatchCost cost = [&](std::span<const std::vector<double>> points, std::span<double> out) {
    parallel_for(
        options.threads, static_cast<int>(points.size()),
        [&](int, int piece) {
          const auto commands =
              designer.kept_within_limits(track_of(trial, limits, designer, courses, options.seconds, points[piece]));
          out[piece] = commands ? designer.cost(*commands) : HUGE_VAL;
        },
        options.control.stop);
  };
  PagmoOptions search;
  search.method = PagmoMethod::cmaes;
  search.population = options.population;
  search.generations = options.generations;
  search.seed = options.seed;
  const OptimizerResult found = run_pagmo(box, cost, search, options.control);
  if (found.interrupted) throw Interrupted();
  if (!std::isfinite(found.best_cost))
    throw WorkError(
        "no motion was found that keeps to the limits of position and speed; widen them or lower --command");
  DesignResult out;
  out.evaluations = found.evaluations;
  out.history = found.history;
  out.best = designer.assessed(
      to_string(options.shape),
      *designer.kept_within_limits(track_of(trial, limits, designer, courses, options.seconds, found.best)));
  out.step = designer.assessed("step", designer.largest_step(options.seconds));
  for (const int s : trial.experiment.with_role(Role::train)) {
    const Segment& segment = trial.experiment.segments[s];
    if (out.recordings.size() < 4) out.recordings.push_back(designer.assessed(segment.file, own_commands(segment)));
  }
  return out;
}

}  // namespace lacuna
