#include "diagnosis/baseline.h"

#include <algorithm>
#include <cmath>

#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kReweightings = 1;
constexpr double kSameWeight = 0.1;  ///< relative change of a weight that is worth another fit

}  // namespace

double noise_seen(const Experiment& experiment, std::size_t channel) {
  std::vector<double> seen;
  for (const Segment& segment : experiment.segments) {
    if (segment.count < 100) continue;
    const std::vector<double> time(
        segment.commands->time.begin() + static_cast<std::ptrdiff_t>(segment.first),
        segment.commands->time.begin() + static_cast<std::ptrdiff_t>(segment.first + segment.count));
    const double rms = noise_from_differences(time, segment.measured[channel]);
    if (std::isfinite(rms)) seen.push_back(rms);
  }
  std::sort(seen.begin(), seen.end());
  return seen.empty() ? std::nan("") : seen[seen.size() / 2];
}

std::vector<double> noise_levels(const PlantModel& model, const Experiment& experiment) {
  const std::vector<Channel> channels = predicted_channels(model, experiment);
  std::vector<double> out;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    double noise = channels[c].noise;
    if (const double seen = channels[c].noise_stated ? noise_seen(experiment, c) : noise; seen > noise) noise = seen;
    out.push_back(noise);
  }
  return out;
}

std::vector<double> weights_from(const CurrentModel& current, const Experiment& experiment,
                                 const SimulatorOptions& options) {
  Problem problem(current.model, experiment, current.space, options, current.weights);
  const std::vector<int> train = experiment.with_role(Role::train);
  std::vector<double> sum(current.weights.size(), 0.0), count = sum, out = current.weights;
  for (const ResidualBlock& block : problem.layout(train)) {
    const std::size_t c = static_cast<std::size_t>(block.channel);
    sum[c] += current.fit.residual.segment(block.first, block.count).squaredNorm();
    count[c] += static_cast<double>(block.count);
  }
  const std::vector<double> noise = noise_levels(current.model, experiment);
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (!(count[c] > 0.0)) continue;
    const double rms = current.weights[c] * std::sqrt(sum[c] / count[c]);
    out[c] = noise[c] > 0.0 ? std::max(noise[c], rms) : std::max(rms, 1e-12);
  }
  return out;
}

bool refit(CurrentModel& model, const Experiment& experiment, const SimulatorOptions& options,
           const RunControl& control, double tolerance, const Eigen::MatrixXd* jacobian) {
  Problem problem(model.model, experiment, model.space, options, model.weights);
  LeastSquaresOptions finish;
  finish.iterations = kRefitIterations;
  finish.tolerance = tolerance;
  finish.polish = false;
  finish.jacobian = jacobian;
  finish.control = control;
  finish.control.progress = nullptr;
  try {
    model.fit = solve_least_squares(problem, model.fit.point, experiment.with_role(Role::train), finish);
  } catch (const WorkError&) {
    return false;
  }
  return true;
}

void refine(CurrentModel& current, const Experiment& experiment, const SimulatorOptions& options,
            const RunControl& control, int iterations) {
  const std::vector<int> train = experiment.with_role(Role::train);
  LeastSquaresOptions finish;
  finish.control = control;
  finish.iterations = iterations;
  finish.polish = false;  // the search's own solution was polished; this follows a change of weights
  for (int k = 0;; ++k) {
    Problem problem(current.model, experiment, current.space, options, current.weights);
    current.fit = solve_least_squares(problem, current.fit.point, train, finish);
    if (k == kReweightings) return;
    const std::vector<double> next = weights_from(current, experiment, options);
    bool same = true;
    for (std::size_t c = 0; c < next.size(); ++c) {
      same = same && std::fabs(next[c] - current.weights[c]) <= kSameWeight * current.weights[c];
    }
    if (same) return;
    current.weights = next;
  }
}

CurrentModel identify_plain(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                            const IdentifyOptions& options, FitResult& fit) {
  IdentifyOptions from_start = options;
  from_start.optimizer = Optimizer::lsq;
  fit = identify(model, experiment, space, from_start);
  if (options.optimizer != Optimizer::lsq && space.size() > 0) {
    IdentifyOptions searched = options;
    searched.step = fit.step.step;
    FitResult other = identify(model, experiment, space, searched);
    other.step = fit.step;
    if (other.solution.sum_of_squares < fit.solution.sum_of_squares) {
      fit = std::move(other);
    } else {
      fit.optimizer = other.optimizer;
      fit.history = std::move(other.history);
      fit.search_cost = other.search_cost;
      fit.evaluations += other.evaluations;
    }
  }
  CurrentModel current{model, space, first_weights(model, experiment), fit.solution};
  SimulatorOptions simulator = options.simulator;
  simulator.max_step = fit.step.step;
  const std::vector<double> next = weights_from(current, experiment, simulator);
  bool same = true;
  for (std::size_t c = 0; c < next.size(); ++c) {
    same = same && std::fabs(next[c] - current.weights[c]) <= kSameWeight * current.weights[c];
  }
  if (!same) {
    current.weights = next;
    refine(current, experiment, simulator, options.control, 20);
  }
  record_fit(current, experiment, simulator, fit);
  return current;
}

void record_fit(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& options,
                FitResult& fit) {
  Problem problem(current.model, experiment, current.space, options, current.weights);
  fit.solution = current.fit;
  fit.point = current.fit.point;
  fit.values = current.space.expand(fit.point);
  describe_fit(current.model, current.space, problem, experiment.with_role(Role::train), fit);
  fit.rms.clear();
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    fit.rms.emplace_back(role, residual_rms(problem, fit.values, role));
  }
}

}  // namespace lacuna
