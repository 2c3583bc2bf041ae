#include "compare/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kCommonStep = 1e-3, kFinestStep = 2e-4;  // s
constexpr std::size_t kFewestPoints = 5, kMostRungs = 9;  // of a curve; of a ladder
constexpr double kCoarse = 0.05;                          // rad (m): errors beyond say nothing of an order
constexpr double kAboveReferee = 100.0;                   // times the referee's error
constexpr double kEngineRounding = 1e-12;                 // rad (m): engines' own, over thousands of steps

/// Sub-nanosecond slack for steps that should be equal.
bool at_most(double a, double b) { return a <= b * (1.0 + 1e-9); }

WorkPoint point_of(const Trajectory& run, const Motion& window, const Referee& referee) {
  WorkPoint out;
  const ErrorSeries series = error_of(run, referee);
  out.stable = series.stable;
  out.error = series.stable ? series.worst : HUGE_VAL;
  out.steps_per_second = static_cast<double>(run.steps) / window.duration();
  return out;
}

void measure_adaptive(const Runner& runner, const Motion& window, const Referee& referee, MethodResult& out,
                      const StopFlag* stop) {
  double last = 0.0;
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    if (stop != nullptr && *stop) throw Interrupted();
    if (out.points.size() >= kFewestPoints && 1.6 * last > kLongestRun)
      return;  // a decade of tolerance is a factor of 10^(1/5) in steps
    const Trajectory run = runner.run_adaptive(tolerance, stop);
    last = run.seconds;
    out.points.push_back(point_of(run, window, referee));
    out.points.back().tolerance = tolerance;
  }
}

void find_stable_step(MethodResult& out) {
  for (auto at = out.points.rbegin(); at != out.points.rend() && at->stable; ++at) out.largest_stable_step = at->step;
  out.stable_at_longest = !out.points.empty() && out.points.front().step == out.largest_stable_step;
}

}  // namespace

double common_step(const Motion& motion) {
  double step = motion.longest_step();
  while (!at_most(step, kCommonStep)) step *= 0.5;
  return step;
}

std::vector<double> step_ladder(const Motion& motion) {
  std::vector<double> out;
  for (double step = motion.longest_step(); out.size() < kMostRungs; step *= 0.5) {
    if (!out.empty() && step < kFinestStep && out.size() >= kFewestPoints) break;
    out.push_back(step);
  }
  return out;
}

double order_of(const std::vector<WorkPoint>& points, double referee_error) {
  const double floor = std::max(kAboveReferee * referee_error, kEngineRounding);
  std::vector<double> slopes;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const WorkPoint &coarse = points[i], &fine = points[i + 1];
    if (!(coarse.error < kCoarse) || !(fine.error > floor) || !(coarse.step > fine.step)) continue;
    slopes.push_back(std::log(coarse.error / fine.error) / std::log(coarse.step / fine.step));
  }
  return timing_of(std::move(slopes)).median;
}

void measure_points(Runner& runner, const Motion& window, const Referee& referee, MethodResult& out,
                    const StopFlag* stop) {
  const Method method{out.name, out.native};
  if (out.adaptive()) return measure_adaptive(runner, window, referee, out, stop);
  double last = 0.0;
  for (const double step : step_ladder(window)) {
    if (stop != nullptr && *stop) throw Interrupted();
    if (out.points.size() >= kFewestPoints && 2.0 * last > kLongestRun) break;
    const Trajectory run = runner.run(method, step);
    last = run.seconds;
    out.points.push_back(point_of(run, window, referee));
    out.points.back().step = step;
  }
  out.order = order_of(out.points, referee.record.error);
  find_stable_step(out);
}

Affordable::Affordable(const std::string& engine, const Motion& motion, Runner& whole, const Method& method,
                       double step, double budget)
    : motion_(&motion), whole_(&whole) {
  const Motion first = motion.first(0.0);
  const double pace = Runner(engine, first).run(method, step).seconds / first.duration();
  seconds_ = pace * motion.duration();
  if (seconds_ <= budget) return;
  cut_ = std::make_unique<Motion>(motion.first(budget / pace));
  cut_runner_ = std::make_unique<Runner>(engine, *cut_);
}

void describe_trajectory(const Motion& motion, const Trajectory& run, const Referee& referee, MethodResult& out) {
  const ErrorSeries series = error_of(run, referee);
  out.trajectory_seconds = motion.duration();
  out.trajectory_error = series.worst;
  out.trajectory_error_rms = series.rms;
  out.trajectory_worst_time = series.worst_time;
  out.trajectory_worst_joint = motion.model.robot().joints()[series.worst_joint].name;
  out.error = series.error;
  out.time.assign(referee.times.begin(), referee.times.begin() + static_cast<std::ptrdiff_t>(series.error.size()));
}

}  // namespace lacuna
