#include "diagnosis/baseline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/prior.h"
#include "ga/arrival.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr int kReweightings = 1;
constexpr double kSameWeight = 0.1;  ///< relative change of a weight that is worth another fit

constexpr double kShift = 0.2;  ///< of a standard error: an interval is wider by 2 % for it

constexpr FurtherStarts kOfMotions{2, 60};  ///< of simulated motions: a population search costs no more than another
constexpr double kMissed = 0.5;             ///< of the motion's energy about its mean

constexpr double kSearchStep = 2.0;  ///< steps of the population search over those of the fit: it ranks only

/// Weights after the present residual, if one of them differs by enough; whether it does.
bool update_weights(CurrentModel& current, const FitContext& context) {
  std::vector<double> next = weights_from(current, context);
  bool same = true;
  for (std::size_t c = 0; c < next.size(); ++c) {
    same = same && std::fabs(next[c] - current.weights[c]) <= kSameWeight * current.weights[c];
  }
  if (same) return false;
  change_weights(current, context, std::move(next));
  return true;
}

/// Whether the train recordings can be simulated from its point at that step.
bool runs(const CurrentModel& current, const FitContext& context) {
  return problem_of(current, context)
      .residual(current.fit.point, context.experiment.with_role(Role::train))
      .allFinite();
}

/// The population search and its best, re-identified until little is gained: at the present model's step, the search at
/// a coarser one where that model runs. `fit` receives the record of the search. Nothing where no member runs: the
/// present model stands.
std::optional<LeastSquaresResult> search(const CurrentModel& present, const FitContext& context,
                                         const IdentifyOptions& options, FitResult& fit) {
  IdentifyOptions searched = options;
  if (searched.optimizer == Optimizer::ga_lsq) searched.optimizer = Optimizer::ga;
  const double step = context.simulator.max_step;
  searched.step = runs(present, context.with_step(kSearchStep * step)) ? kSearchStep * step : step;
  CurrentModel best = present;
  try {
    fit = identify(present.model, context.experiment, present.space, searched);
  } catch (const WorkError&) {
    return std::nullopt;
  }
  best.fit = fit.solution;
  if (!refit(best, context)) return std::nullopt;
  return best.fit;
}

/// Whether a fit leaves more than kMissed of the motion itself: descents meet there that found none of it.
bool leaves_most_of_the_motion(const CurrentModel& current, const FitContext& context) {
  double motion = 0.0;
  for (const int s : context.experiment.with_role(Role::train)) {
    const std::vector<std::vector<double>>& measured = context.experiment.segments[s].measured;
    for (std::size_t c = 0; c < measured.size(); ++c) {
      double n = 0.0, sum = 0.0, squares = 0.0;
      for (const double x : measured[c])
        if (std::isfinite(x)) n += 1.0, sum += x, squares += x * x;
      if (n > 0.0) motion += (squares - sum * sum / n) / (current.weights[c] * current.weights[c]);
    }
  }
  return current.fit.sum_of_squares > kMissed * motion;
}

/// The best of descents from the start values and from draws about them becomes the present solution; whether two of
/// them met.
bool descend_from_several_starts(const FitContext& context, std::uint64_t seed, CurrentModel& current, FitResult& fit) {
  const auto& axes = current.space.axes();
  const bool simulated = !std::holds_alternative<InverseDynamics>(context.experiment.prediction);
  Problem problem = problem_of(current, context);
  LeastSquaresOptions descent;
  descent.iterations = kRefitIterations;
  descent.tolerance = kRefitTolerance;
  descent.polish = false;
  descent.control = context.control;
  SeveralStarts found =
      from_several_starts(problem, context.experiment.with_role(Role::train), {current.fit},
                          noise_is_known(context.experiment), seed, descent, simulated ? kOfMotions : FurtherStarts());
  current.fit = std::move(found.best);
  fit.evaluations += found.evaluations;
  // Without priors a valley that the data leave open has a wall for an end: beside it two ends say nothing.
  if (std::any_of(axes.begin(), axes.end(), [](const Axis& a) { return std::isfinite(a.prior); })) {
    fit.arrived = found.arrived;
    fit.doubt = found.doubt;
  }
  return found.met;
}

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

std::vector<double> noise_levels(const Experiment& experiment) {
  const std::vector<Channel>& channels = experiment.channels;
  std::vector<double> out;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    double noise = channels[c].noise;
    const bool as_read = channels[c].noise_stated && experiment.segments.front().compared.empty();
    if (const double seen = as_read ? noise_seen(experiment, c) : noise; seen > noise) noise = seen;
    out.push_back(noise);
  }
  return out;
}

std::vector<double> noise_over_weight(const Experiment& experiment, std::span<const double> weights) {
  std::vector<double> out = noise_levels(experiment);
  for (std::size_t c = 0; c < out.size(); ++c) out[c] /= weights[c];
  return out;
}

std::vector<double> weights_from(const CurrentModel& current, const FitContext& context) {
  Problem problem = problem_of(current, context);
  const std::vector<int> train = context.experiment.with_role(Role::train);
  std::vector<double> sum(current.weights.size(), 0.0), count = sum, out = current.weights;
  for (const ResidualBlock& block : problem.layout(train)) {
    const std::size_t c = block.channel;
    sum[c] += current.fit.residual.segment(block.first, block.count).squaredNorm();
    count[c] += static_cast<double>(block.count);
  }
  const std::vector<double> noise = noise_levels(context.experiment);
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (!(count[c] > 0.0)) continue;
    const double rms = current.weights[c] * std::sqrt(sum[c] / count[c]);
    out[c] = noise[c] > 0.0 ? std::max(noise[c], rms) : std::max(rms, 1e-12);
  }
  return out;
}

bool refit(CurrentModel& model, const FitContext& context, double tolerance, const Eigen::MatrixXd* jacobian,
           int iterations) {
  Problem problem = problem_of(model, context);
  LeastSquaresOptions finish;
  finish.iterations = iterations;
  finish.tolerance = tolerance;
  finish.polish = false;
  finish.jacobian = jacobian;
  finish.control = context.control.quiet();
  try {
    model.fit = solve_least_squares(problem, model.fit.point, context.experiment.with_role(Role::train), finish);
  } catch (const WorkError&) {
    return false;
  }
  return true;
}

void change_weights(CurrentModel& model, const FitContext& context, std::vector<double> weights) {
  const std::vector<int> train = context.experiment.with_role(Role::train);
  const Problem before = problem_of(model, context);
  const Problem after = problem_of(model, context, weights);
  model.fit.residual = after.reweighed(std::move(model.fit.residual), before, train);
  model.fit.jacobian = after.reweighed(std::move(model.fit.jacobian), before, train);
  model.weights = std::move(weights);
}

void evaluate_at(CurrentModel& model, std::vector<double> point, const FitContext& context) {
  Problem problem = problem_of(model, context);
  const std::vector<int> train = context.experiment.with_role(Role::train);
  model.fit = {};
  model.fit.point = std::move(point);
  model.fit.residual = problem.residual(model.fit.point, train);
  model.fit.jacobian = problem.jacobian(model.fit.point, model.fit.residual, train);
  model.fit.sum_of_squares = model.fit.residual.squaredNorm();
  model.fit.prior_cost = prior_cost(model.space.axes(), model.fit.point);
}

CurrentModel seen_in(const CurrentModel& model, const FitContext& context) {
  CurrentModel out{model.model, model.space, model.weights, {}};
  evaluate_at(out, model.fit.point, context);
  return out;
}

void refine(CurrentModel& current, const FitContext& context, int iterations) {
  const std::vector<int> train = context.experiment.with_role(Role::train);
  LeastSquaresOptions finish;
  finish.control = context.control;
  finish.iterations = iterations;
  finish.polish = false;
  finish.nearby = true;
  for (int k = 0;; ++k) {
    Problem problem = problem_of(current, context);
    const Eigen::MatrixXd known = std::move(current.fit.jacobian);
    const auto size = static_cast<Eigen::Index>(current.space.size());
    finish.jacobian = known.cols() == size && known.rows() == current.fit.residual.size() ? &known : nullptr;
    current.fit = solve_least_squares(problem, current.fit.point, train, finish);
    if (k == kReweightings || !update_weights(current, context)) return;
  }
}

double settle(CurrentModel& current, FitContext context) {
  const std::vector<int> train = context.experiment.with_role(Role::train);
  double& step = context.simulator.max_step;
  const bool simulated = !std::holds_alternative<InverseDynamics>(context.experiment.prediction);
  while (simulated && current.space.size() > 0 && 0.5 * step >= kShortestStep) {
    Problem problem = problem_of(current, context);
    if (!(shift_by_integration(problem, train, current.fit) > kShift)) break;
    step *= 0.5;
    refine(current, context);
  }
  return step;
}

CurrentModel identify_plain(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                            const IdentifyOptions& options, FitResult& fit) {
  IdentifyOptions from_start = options;
  from_start.optimizer = Optimizer::lsq;
  from_start.tolerance = kRefitTolerance;
  fit = identify(model, experiment, space, from_start);
  const FitContext context = FitContext{experiment, options.simulator, options.control}.with_step(fit.step.step);
  CurrentModel current{model, space, first_weights(model, experiment), fit.solution};
  const bool arrived = space.size() == 0 || (descend_from_several_starts(context, options.genetic.seed, current, fit) &&
                                             !leaves_most_of_the_motion(current, context));
  if (!arrived && options.optimizer != Optimizer::lsq) {
    FitResult searched;
    std::optional<LeastSquaresResult> other = search(current, context, options, searched);
    fit.optimizer = to_string(options.optimizer);
    fit.history = std::move(searched.history);
    fit.search_cost = searched.search_cost;
    fit.evaluations += searched.evaluations + (other ? other->evaluations : 0);
    if (other && energy(*other) < energy(current.fit)) current.fit = std::move(*other);
  }
  update_weights(current, context);
  refine(current, context);
  record_fit(current, context, fit);
  return current;
}

void record_fit(const CurrentModel& current, const FitContext& context, FitResult& fit) {
  Problem problem = problem_of(current, context);
  fit.solution = current.fit;
  fit.point = current.fit.point;
  fit.values = current.space.expand(fit.point);
  describe_fit(current.model, current.space, problem, context.experiment.with_role(Role::train), fit);
  carry_scale_error(current.model, current.space, context.experiment, fit.estimates);
  fit.rms.clear();
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    fit.rms.emplace_back(role, residual_rms(problem, fit.values, role));
  }
}

}  // namespace lacuna
