// Error against time, against step and against computing time; order of convergence; the longest stable step.
#pragma once

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/referee.h"
#include "compare/runner.h"

namespace lacuna {

/// What one run of a curve may be expected to take before it is left out, s of computing. Five are made on any machine.
inline constexpr double kLongestRun = 0.4;
/// The same for the one run at the comparison's own step: of a longer one only the start is made.
inline constexpr double kLongestMainRun = 1.5;
/// Motion over which steps are varied, s.
inline constexpr double kWindow = 1.0;

/// The step of the comparison's common figures: the longest halving of the motion's sample spacing up to 1 ms.
double common_step(const Motion& motion);

/// Steps to try: halvings of the motion's longest, down to about 0.2 ms.
std::vector<double> step_ladder(const Motion& motion);

/// Runs the method on the ladder and fills points, order, largest_stable_step. `window`: the motion's first seconds,
/// which `runner` runs; `referee` may reach further.
void measure_points(Runner& runner, const Motion& window, const Referee& referee, MethodResult& out,
                    const StopFlag* stop);

/// Order from (step, error) pairs: the median slope of log error over log step between neighbours where the error is
/// under a tenth of the coarsest meaningful one and above a hundred times the referee's own. NaN where no pair is.
double order_of(const std::vector<WorkPoint>& points, double referee_error);

/// A motion on one engine by one method, or as much of its start as takes kLongestMainRun, judged by its first
/// interval.
class Affordable {
 public:
  /// `whole` runs `motion`; both must outlive this.
  Affordable(const std::string& engine, const Motion& motion, Runner& whole, const Method& method, double step,
             double budget = kLongestMainRun);

  const Motion& motion() const { return cut_ ? *cut_ : *motion_; }
  Runner& runner() const { return cut_ ? *cut_runner_ : *whole_; }
  double seconds() const { return seconds_; }  ///< of computing that the whole motion would take

 private:
  const Motion* motion_;
  Runner* whole_;
  std::unique_ptr<Motion> cut_;
  std::unique_ptr<Runner> cut_runner_;
  double seconds_ = 0.0;
};

/// Fills the trajectory figures from a run of the motion, or of its start.
void describe_trajectory(const Motion& motion, const Trajectory& run, const Referee& referee, MethodResult& out);

}  // namespace lacuna
