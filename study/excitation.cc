#include "study/excitation.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "ga/enum_names.h"
#include "ga/pagmo_optimizers.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr std::array<const char*, 3> kShapes = {"multisine", "staircase", "both"};
constexpr double kRest = 0.5;            // s at zero command before anything moves
constexpr int kSines = 8, kStairs = 10;  // per joint and motion
constexpr double kWeakened = 0.8;        // a motion beyond its limits is weakened to this share, at most so often:
constexpr int kWeakenings = 16;
constexpr int kBisections = 12;

/// One joint's command over `time` from coordinates in [0, 1]: a sum of sines spread over the band, or stairs of drawn
/// heights and lengths; `seconds` long, at most `peak`.
class Courses {
 public:
  Courses(Shape shape, double seconds, double hertz) : shape_(shape), seconds_(seconds), hertz_(hertz) {}

  /// Coordinates of one joint.
  std::size_t size() const {
    const std::size_t sines = 2 * kSines + 1, stairs = 2 * kStairs;
    return shape_ == Shape::multisine ? sines : shape_ == Shape::staircase ? stairs : sines + stairs;
  }

  std::vector<double> course(std::span<const double> x, const std::vector<double>& time, double peak) const {
    if (shape_ == Shape::multisine) return sines(x, time, kRest, seconds_, peak);
    if (shape_ == Shape::staircase) return stairs(x, time, kRest, seconds_, peak);
    const double half = 0.5 * (kRest + seconds_);
    std::vector<double> out = stairs(x.first(2 * kStairs), time, kRest, half, peak);
    const std::vector<double> second = sines(x.subspan(2 * kStairs), time, half, seconds_, peak);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += second[k];
    return out;
  }

 private:
  std::vector<double> sines(std::span<const double> x, const std::vector<double>& time, double from, double to,
                            double peak) const {
    std::vector<double> out(time.size(), 0.0);
    const double low = 1.0 / (to - from), ratio = std::max(hertz_ / low, 1.0);
    double highest = 0.0;
    for (std::size_t k = 0; k < time.size(); ++k) {
      if (time[k] < from || time[k] >= to) continue;
      for (int s = 0; s < kSines; ++s) {
        const double frequency = low * std::pow(ratio, s / (kSines - 1.0));
        const double phase = 2.0 * std::numbers::pi * (frequency * (time[k] - from) + x[2 * s + 1]);
        out[k] += x[2 * s] * std::sin(phase);
      }
      highest = std::max(highest, std::fabs(out[k]));
    }
    const double scale = highest > 0.0 ? peak * x[2 * kSines] / highest : 0.0;
    for (double& u : out) u *= scale;
    return out;
  }

  std::vector<double> stairs(std::span<const double> x, const std::vector<double>& time, double from, double to,
                             double peak) const {
    // Lengths in proportion to their coordinates, none shorter than half a period of the highest frequency.
    const double shortest = std::min(0.5 / hertz_, (to - from) / kStairs);
    double sum = 0.0;
    for (int s = 0; s < kStairs; ++s) sum += x[2 * s + 1] + 1e-9;
    std::vector<double> out(time.size(), 0.0);
    double begin = from;
    for (int s = 0; s < kStairs; ++s) {
      const double end = begin + shortest + (to - from - kStairs * shortest) * (x[2 * s + 1] + 1e-9) / sum;
      for (std::size_t k = 0; k < time.size(); ++k) {
        if (time[k] >= begin && time[k] < end) out[k] = peak * (2.0 * x[2 * s] - 1.0);
      }
      begin = end;
    }
    return out;
  }

  Shape shape_;
  double seconds_, hertz_;
};

/// What a motion does, as far as it is seen: positions and speeds of joints whose position is measured.
struct Motion {
  bool finite = true;
  double beyond = 0.0;  ///< how far it leaves its limits, relative; 0: it keeps to them
  std::vector<double> lowest, highest, speed;
};

class Designer {
 public:
  Designer(const Trial& trial, const MotionLimits& limits) : trial_(trial), limits_(limits) {
    const std::size_t n = static_cast<std::size_t>(trial.model->dof());
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

  Motion move(const Experiment& experiment) const {
    SimulatorOptions options;
    options.max_step = trial_.step.step;
    Motion out;
    const std::size_t n = static_cast<std::size_t>(trial_.model->dof());
    out.lowest.assign(n, std::nan(""));
    out.highest = out.speed = out.lowest;
    const std::vector<std::vector<double>> one{trial_.model->values()};
    const std::vector<int> segments{0};
    make_simulator(*trial_.model, experiment, options)->run(one, segments, [&](int, int, const auto& predicted) {
      for (std::size_t c = 0; c < predicted.size(); ++c) look(experiment, c, predicted[c], out);
    });
    return out;
  }

  Design assessed(const std::string& name, const CommandTrack& commands) const {
    const Experiment experiment = commanded(trial_, commands, rest_);
    const Motion motion = move(experiment);
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
      const Motion motion = move(commanded(trial_, commands, rest_));
      if (motion.finite && motion.beyond == 0.0) return commands;
      for (auto& column : commands.value) {
        for (double& u : column) u *= kWeakened;
      }
    }
    return std::nullopt;
  }

  /// Minus the information; infinite where it cannot be had.
  double cost(const CommandTrack& commands) const {
    const double found = log_det(sensitivities(task_of(commanded(trial_, commands, rest_)), trial_.start));
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
      const Motion motion = move(commanded(trial_, at(share), rest_));
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

  void look(const Experiment& experiment, std::size_t c, const std::vector<double>& signal, Motion& out) const {
    if (experiment.channels[c].kind != ChannelKind::position) return;
    const std::size_t j = static_cast<std::size_t>(experiment.channels[c].joint);
    const Segment& segment = experiment.segments.front();
    double low = HUGE_VAL, high = -HUGE_VAL, fastest = 0.0;
    for (std::size_t k = 0; k < signal.size(); ++k) {
      if (!std::isfinite(signal[k])) {
        out.finite = false;
        return;
      }
      low = std::min(low, signal[k]), high = std::max(high, signal[k]);
      if (k > 0)
        fastest = std::max(fastest, std::fabs(signal[k] - signal[k - 1]) / (segment.time(k) - segment.time(k - 1)));
    }
    out.lowest[j] = low, out.highest[j] = high, out.speed[j] = fastest;
    const auto astray = [&](double excess, double size) {
      if (excess > 0.0) out.beyond = std::max(out.beyond, excess / std::max(size, 1e-9));
    };
    const double width =
        std::isfinite(limits_.highest[j] - limits_.lowest[j]) ? limits_.highest[j] - limits_.lowest[j] : 1.0;
    astray(limits_.lowest[j] - low, width);
    astray(high - limits_.highest[j], width);
    astray(fastest - limits_.speed[j], limits_.speed[j]);
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
  const std::vector<double> still(limits.command.size(), 0.0);
  CommandTrack out = step_commands(trial, still, seconds);
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

namespace {

/// Fastest motion of a recorded signal, over strides that keep its noise small.
double fastest_in(const Segment& segment, const std::vector<double>& signal) {
  constexpr std::size_t kStride = 5;
  double out = 0.0;
  for (std::size_t k = kStride; k < signal.size(); ++k) {
    const double v = (signal[k] - signal[k - kStride]) / (segment.time(k) - segment.time(k - kStride));
    if (std::isfinite(v)) out = std::max(out, std::fabs(v));
  }
  return out;
}

}  // namespace

MotionLimits motion_limits(const Trial& trial, double command, double reach, double speed) {
  MotionLimits out;
  const Experiment& seen = trial.experiment;
  const Segment& first = seen.segments[static_cast<std::size_t>(seen.with_role(Role::train).front())];
  for (std::size_t j = 0; j < static_cast<std::size_t>(trial.model->dof()); ++j) {
    const Joint& joint = trial.model->robot().joints()[j];
    double peak = 0.0, low = joint.lower, high = joint.upper, fastest = joint.velocity;
    for (const Segment& segment : seen.segments) {
      for (const double u : segment.commands->value[j]) peak = std::max(peak, std::fabs(u));
      for (std::size_t c = 0; c < seen.channels.size(); ++c) {
        if (seen.channels[c].kind != ChannelKind::position || seen.channels[c].joint != static_cast<int>(j)) continue;
        for (const double q : segment.measured[c]) {
          if (std::isfinite(q)) low = std::min(low, q), high = std::max(high, q);
        }
        fastest = std::max(fastest, fastest_in(segment, segment.measured[c]));
      }
    }
    out.command.push_back(std::isnan(command) ? peak : command);
    out.lowest.push_back(std::isnan(reach) ? low : std::max(low, first.q0[j] - reach));
    out.highest.push_back(std::isnan(reach) ? high : std::min(high, first.q0[j] + reach));
    out.speed.push_back(std::isnan(speed) ? fastest : std::min(fastest, speed));
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
          const std::size_t i = static_cast<std::size_t>(piece);
          const auto commands =
              designer.kept_within_limits(track_of(trial, limits, designer, courses, options.seconds, points[i]));
          out[i] = commands ? designer.cost(*commands) : HUGE_VAL;
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
    const Segment& segment = trial.experiment.segments[static_cast<std::size_t>(s)];
    if (out.recordings.size() < 4) out.recordings.push_back(designer.assessed(segment.file, own_commands(segment)));
  }
  return out;
}

}  // namespace lacuna
