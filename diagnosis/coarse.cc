#include "diagnosis/coarse.h"

#include "diagnosis/baseline.h"
#include "diagnosis/thinned.h"

namespace lacuna {
namespace {

constexpr double kCorrected = 0.1;  ///< energy of the correction over the residual's
constexpr int kDoublings = 2;
constexpr double kTraceOfRest = 0.01;  ///< of a residual's energy

}  // namespace

std::vector<Eigen::VectorXd> CoarseLook::residuals_of(Problem& problem, std::span<const std::vector<double>> values,
                                                      std::span<const int> train) const {
  std::vector<Eigen::VectorXd> out = problem.residuals_of(values, train);
  for (Eigen::VectorXd& residual : out) residual += correction;
  return out;
}

CoarseLook coarse_look(const CurrentModel& current, const FitContext& context) {
  const std::vector<int> train = context.experiment.with_role(Role::train);
  const Eigen::VectorXd& present = current.fit.residual;
  CoarseLook out{context, Eigen::VectorXd::Zero(present.size())};
  // Steps end at samples: one longer than the sampling period is none.
  for (int k = 0; k < kDoublings && 2.0 * out.context.simulator.max_step <= context.experiment.sample_period; ++k) {
    const FitContext longer = context.with_step(2.0 * out.context.simulator.max_step);
    Problem problem = problem_of(current, longer);
    const Eigen::VectorXd correction = present - problem.residual(current.fit.point, train);
    if (!(correction.squaredNorm() <= kCorrected * present.squaredNorm())) break;
    out.context.simulator = longer.simulator, out.correction = correction;
  }
  return out;
}

bool step_matters(const CurrentModel& current, const FitContext& context, double step) {
  Problem problem = problem_of(current, context.with_step(step));
  const Eigen::VectorXd& present = current.fit.residual;
  const Eigen::VectorXd change =
      problem.residual(current.fit.point, context.experiment.with_role(Role::train)) - present;
  return !(change.squaredNorm() <= kTraceOfRest * present.squaredNorm());
}

double coarse_enough(const CurrentModel& current, const FitContext& context) {
  double out = context.simulator.max_step;
  for (double step = 2.0 * out; step <= context.experiment.sample_period; step *= 2.0) {
    if (step_matters(current, context, step)) break;
    out = step;
  }
  return out;
}

Enough::Enough(const CurrentModel& current, const FitContext& context)
    : experiment_(thinned(context.experiment)), context_(context.on(experiment_)) {
  const bool fewer = experiment_.segments.size() < context.experiment.segments.size();
  context_.simulator.max_step = coarse_enough(fewer ? seen_in(current, context_) : current, context_);
  all_ = !fewer && context_.simulator.max_step == context.simulator.max_step;
}

}  // namespace lacuna
