#include "diagnosis/coarse.h"

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

CoarseLook coarse_look(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator) {
  const std::vector<int> train = experiment.with_role(Role::train);
  const Eigen::VectorXd& present = current.fit.residual;
  CoarseLook out{simulator, Eigen::VectorXd::Zero(present.size())};
  // Steps end at samples: one longer than the sampling period is none.
  for (int k = 0; k < kDoublings && 2.0 * out.simulator.max_step <= experiment.sample_period; ++k) {
    SimulatorOptions longer = out.simulator;
    longer.max_step *= 2.0;
    Problem problem(current.model, experiment, current.space, longer, current.weights);
    const Eigen::VectorXd correction = present - problem.residual(current.fit.point, train);
    if (!(correction.squaredNorm() <= kCorrected * present.squaredNorm())) break;
    out = {longer, correction};
  }
  return out;
}

bool step_matters(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
                  double step) {
  SimulatorOptions other = simulator;
  other.max_step = step;
  Problem problem(current.model, experiment, current.space, other, current.weights);
  const Eigen::VectorXd& present = current.fit.residual;
  const Eigen::VectorXd change = problem.residual(current.fit.point, experiment.with_role(Role::train)) - present;
  return !(change.squaredNorm() <= kTraceOfRest * present.squaredNorm());
}

SimulatorOptions coarse_enough(const CurrentModel& current, const Experiment& experiment,
                               const SimulatorOptions& simulator) {
  SimulatorOptions out = simulator;
  for (double step = 2.0 * simulator.max_step; step <= experiment.sample_period; step *= 2.0) {
    if (step_matters(current, experiment, simulator, step)) break;
    out.max_step = step;
  }
  return out;
}

}  // namespace lacuna
