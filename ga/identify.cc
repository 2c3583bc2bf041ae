#include "ga/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "ga/arrival.h"
#include "ga/pagmo_optimizers.h"
#include "ga/sandwich.h"
#include "ga/start_effects.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;
/// A value this near a bound, as a share of the range, counts as stuck at it.
constexpr double kAtBound = 1e-4;
constexpr double kIdentifiable = 0.5;

constexpr std::pair<Optimizer, const char*> kNames[] = {{Optimizer::ga, "ga"},
                                                        {Optimizer::cmaes, "cmaes"},
                                                        {Optimizer::de, "de"},
                                                        {Optimizer::lsq, "lsq"},
                                                        {Optimizer::ga_lsq, "ga+lsq"}};

OptimizerResult search_population(Problem& problem, const IdentifyOptions& options, std::span<const int> segments) {
  const Box box = problem.space().box(problem.model());
  const BatchCost cost = [&](std::span<const std::vector<double>> points, std::span<double> out) {
    problem.costs(points, out, segments, options.fitness);
  };
  switch (options.optimizer) {
    case Optimizer::cmaes:
    case Optimizer::de: {
      PagmoOptions pagmo;
      pagmo.population = options.genetic.population;
      pagmo.generations = options.genetic.generations;
      pagmo.seed = options.genetic.seed;
      pagmo.method = options.optimizer == Optimizer::cmaes ? PagmoMethod::cmaes : PagmoMethod::de;
      return run_pagmo(box, cost, pagmo, options.control);
    }
    default: return run_genetic_algorithm(box, cost, options.genetic, options.control);
  }
}

Estimate estimate_of(const PlantModel& model, const Axis& axis, double x, double error, double relative_error) {
  const Parameter& p = model.parameters()[axis.parameter];
  double low = x - kTwoSided95 * error, high = x + kTwoSided95 * error;
  if (axis.coordinate == Coordinate::inverse) {
    const double a = low > 0.0 ? 1.0 / low : HUGE_VAL, b = 1.0 / std::max(high, 1e-300);
    low = std::min(a, b), high = std::max(a, b);
  } else if (axis.coordinate == Coordinate::logarithm) {
    const double a = axis.value(low), b = axis.value(high);
    low = std::min(a, b), high = std::max(a, b);
  }
  const bool spans = x - kTwoSided95 * error <= axis.lower && x + kTwoSided95 * error >= axis.upper;
  const double margin = kAtBound * std::min(axis.upper - axis.lower, std::fabs(x) + 1e-12);
  return {p.name,
          p.unit,
          axis.value(x),
          std::max(low, p.lower),
          std::min(high, p.upper),
          relative_error < kIdentifiable && !spans,
          x <= axis.lower + margin || x >= axis.upper - margin,
          false,
          spans};
}

/// A fit in units of what each channel is left with.
struct ByChannel {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residual;
  double effective = 0.0;  ///< samples of all channels
};

/// Rows of a channel over its own rms, its slow noise counted at its effective samples, so that what one joint's model
/// lacks widens no other joint's intervals.
ByChannel whitened_by_channel(Problem& problem, std::span<const ResidualBlock> blocks, const LeastSquaresResult& s) {
  ByChannel out{s.jacobian, s.residual};
  const double n = static_cast<double>(s.residual.size()), p = static_cast<double>(s.jacobian.cols());
  for (std::size_t c = 0; c < problem.weights().size(); ++c) {
    std::vector<ResidualBlock> own;
    double energy = 0.0, samples = 0.0;
    for (const ResidualBlock& block : blocks) {
      if (block.channel != static_cast<int>(c) || block.count == 0) continue;
      own.push_back(block);
      energy += s.residual.segment(block.first, block.count).squaredNorm();
      samples += static_cast<double>(block.count);
    }
    if (own.empty()) continue;
    const double independent = effective_samples(s.residual, own);
    out.effective += independent;
    // A stated noise is a floor: a residual below it makes no parameter better known than its instrument allows.
    const auto& channels = problem.experiment().channels;
    const bool stated = channels[c].noise_stated && problem.weights()[c] == channels[c].noise;
    const double freedom = std::max(samples * (1.0 - p / n), 1.0);
    const double variance = std::max(energy / freedom, stated ? 1.0 : 1e-300);
    const double unit = std::sqrt(independent / samples / variance);
    for (const ResidualBlock& block : own) {
      if (out.jacobian.rows() == s.residual.size()) out.jacobian.middleRows(block.first, block.count) *= unit;
      out.residual.segment(block.first, block.count) *= unit;
    }
  }
  return out;
}

/// Standard errors of the search point: those of white noise as large as what is left or, where that is more, those
/// that hold for what is left as it is.
Eigen::VectorXd standard_errors(const Identifiability& known, const ByChannel& fit,
                                std::span<const ResidualBlock> blocks) {
  const Eigen::VectorXd white = known.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (fit.jacobian.rows() != fit.residual.size()) return white;
  const double correlation = static_cast<double>(fit.residual.size()) / std::max(fit.effective, 1.0);
  return white.cwiseMax(
      sandwich_errors(known.covariance, fit.jacobian, fit.residual, time_blocks(blocks, correlation)));
}

/// Standard errors as they are reported, and what they rest on.
Eigen::VectorXd reported_errors(Problem& problem, std::span<const int> segments, const LeastSquaresResult& s,
                                double& effective, Identifiability& known) {
  const auto blocks = problem.layout(segments);
  const ByChannel whitened = whitened_by_channel(problem, blocks, s);
  effective = whitened.effective;
  known = identifiability(problem.space(), s.point, whitened.jacobian, 1.0, 1.0);
  return standard_errors(known, whitened, blocks);
}

Estimate mass_estimate(const PlantModel& model, int parameter, double value, double low, double high) {
  const Parameter& p = model.parameters()[parameter];
  return {p.name, p.unit, value, low, high, false, false, false};
}

/// The mass that is the total less the others, which are axes: the variance of their sum.
void add_rest_of_total(const PlantModel& model, const SearchSpace& space, FitResult& fit) {
  double sum = 0.0;
  for (std::size_t a = 0; a < space.size(); ++a) {
    for (std::size_t b = 0; b < space.size(); ++b) {
      const bool masses = model.parameters()[space.axes()[a].parameter].info == nullptr &&
                          model.parameters()[space.axes()[b].parameter].info == nullptr;
      if (masses) sum += fit.identifiability.covariance(a, b);
    }
  }
  const double value = fit.values[space.dependent()], error = std::sqrt(std::max(sum, 0.0));
  fit.estimates.push_back(
      mass_estimate(model, space.dependent(), value, value - kTwoSided95 * error, value + kTwoSided95 * error));
  fit.estimates.back().identifiable = error < kIdentifiable * value;
  fit.estimates.back().derived = true;
}

/// d log mass / d point of each shared mass, in their order: its own axis less the mean of all, weighed by mass.
Eigen::MatrixXd shared_mass_slopes(const SearchSpace& space, const FitResult& fit) {
  const auto& masses = space.shared_masses();
  double total = 0.0;
  for (const SharedMass& m : masses) total += fit.values[m.parameter];
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(space.size());
  for (const SharedMass& m : masses)
    if (m.axis >= 0) mean(m.axis) = fit.values[m.parameter] / total;
  Eigen::MatrixXd out = (-mean).replicate(masses.size(), 1);
  for (std::size_t i = 0; i < masses.size(); ++i)
    if (masses[i].axis >= 0) out(i, masses[i].axis) += 1.0;
  return out;
}

/// Masses that share a known total, in place of their axes' estimates: an axis is a ratio to another mass.
void describe_shared_masses(const PlantModel& model, const SearchSpace& space, FitResult& fit) {
  const auto& masses = space.shared_masses();
  const Eigen::MatrixXd slopes = shared_mass_slopes(space, fit);
  const auto errors = [&](const Eigen::MatrixXd& covariance) -> Eigen::VectorXd {
    return (slopes * covariance * slopes.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
  };
  const Eigen::VectorXd error = errors(fit.identifiability.covariance), by_data = errors(fit.identifiability.by_data);
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const SharedMass& m = masses[i];
    const double value = fit.values[m.parameter];
    const double factor = std::exp(kTwoSided95 * error(i));
    Estimate estimate = mass_estimate(model, m.parameter, value, value / factor, value * factor);
    estimate.identifiable = by_data(i) < kIdentifiable;
    const double margin = kAtBound * std::min(m.upper - m.lower, value);
    estimate.at_bound = value <= m.lower + margin || value >= m.upper - margin;
    estimate.derived = m.axis < 0;
    if (m.axis >= 0) {
      fit.estimates[m.axis] = estimate;
    } else {
      fit.estimates.push_back(estimate);
    }
  }
}

/// Weights of an undetermined direction over the parameters' relative changes: masses that share a total are named for
/// themselves, not for the ratios that are searched.
std::string direction_in_words(const PlantModel& model, const SearchSpace& space, const FitResult& fit,
                               const std::vector<double>& weights) {
  std::vector<std::string> names = space.box(model).names;
  if (space.shared_masses().empty()) return combination_in_words(weights, names);
  std::vector<double> own = weights;
  const Eigen::VectorXd moved = shared_mass_slopes(space, fit) * Eigen::VectorXd::Map(weights.data(), weights.size());
  for (std::size_t i = 0; i < space.shared_masses().size(); ++i) {
    const SharedMass& mass = space.shared_masses()[i];
    if (mass.axis < 0) {
      own.push_back(0.0);
      names.push_back(model.parameters()[mass.parameter].name);
    }
    own[mass.axis < 0 ? own.size() - 1 : static_cast<std::size_t>(mass.axis)] = moved(i);
  }
  double square = 0.0;
  for (const double w : own) square += w * w;
  for (double& w : own) w /= std::sqrt(std::max(square, 1e-300));
  return combination_in_words(own, names);
}

}  // namespace

const char* to_string(Optimizer optimizer) {
  for (const auto& [value, name] : kNames) {
    if (value == optimizer) return name;
  }
  return "";
}

Optimizer optimizer_from_name(const std::string& name) {
  std::string known;
  for (const auto& [value, text] : kNames) {
    if (name == text) return value;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw InputError("--optimizer", quoted(name), "one of " + known);
}

std::string combination_in_words(const std::vector<double>& weights, const std::vector<std::string>& names) {
  std::vector<std::size_t> order(weights.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::fabs(weights[a]) > std::fabs(weights[b]); });
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(order.size(), 5); ++k) {
    const double weight = weights[order[k]];
    if (std::fabs(weight) < 0.15) break;
    text += fmt::format("{}{:.2f} {}", text.empty() ? (weight < 0 ? "-" : "") : (weight < 0 ? " - " : " + "),
                        std::fabs(weight), names[order[k]]);
  }
  return text;
}

std::string rms_entry(const Channel& channel, const Experiment& experiment) {
  const std::string& joint = experiment.joint_names[channel.joint];
  const bool inverse = std::holds_alternative<InverseDynamics>(experiment.prediction);
  const bool effort = channel.kind == ChannelKind::effort || channel.kind == ChannelKind::command;
  return (inverse ? effort : channel.kind == ChannelKind::position) ? joint : joint + "." + to_string(channel.kind);
}

JointRms residual_rms(Problem& problem, std::span<const double> values, Role role) {
  const std::vector<int> segments = problem.experiment().with_role(role);
  if (segments.empty()) return {};
  const std::vector<std::vector<double>> one{std::vector<double>(values.begin(), values.end())};
  return rms_by_channel(problem, problem.plain_residuals_of(one, segments).front(), segments);
}

JointRms rms_by_channel(const Problem& problem, const Eigen::VectorXd& r, std::span<const int> segments) {
  JointRms out;
  const std::vector<Channel>& channels = problem.experiment().channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    double sum = 0.0;
    Eigen::Index n = 0;
    for (const ResidualBlock& block : problem.layout(segments)) {
      if (block.channel != static_cast<int>(c)) continue;
      sum += r.segment(block.first, block.count).squaredNorm();
      n += block.count;
    }
    const std::string name = rms_entry(channels[c], problem.experiment());
    out.emplace_back(name, n > 0 ? problem.weights()[c] * std::sqrt(sum / static_cast<double>(n)) : std::nan(""));
  }
  return out;
}

void describe_fit(const PlantModel& model, const SearchSpace& space, Problem& problem, std::span<const int> segments,
                  FitResult& fit) {
  const LeastSquaresResult& s = fit.solution;
  const Eigen::VectorXd errors = reported_errors(problem, segments, s, fit.effective_samples, fit.identifiability);
  fit.estimates.clear();
  for (std::size_t a = 0; a < space.size(); ++a) {
    fit.estimates.push_back(
        estimate_of(model, space.axes()[a], s.point[a], errors(a), fit.identifiability.relative_error[a]));
  }
  fit.undetermined.clear();
  for (const auto& direction : fit.identifiability.undetermined) {
    fit.undetermined.push_back(direction_in_words(model, space, fit, direction.weights));
  }
  if (!space.shared_masses().empty()) {
    describe_shared_masses(model, space, fit);
  } else if (space.dependent() >= 0) {
    add_rest_of_total(model, space, fit);
  }
}

double shift_by_integration(Problem& problem, std::span<const int> segments, const LeastSquaresResult& solution) {
  constexpr double kExact = 1e-5;  // of a number's size: without noise there is no error to hold a shift against
  const auto& axes = problem.space().axes();
  double effective = 0.0;
  Identifiability known;
  const Eigen::VectorXd errors = reported_errors(problem, segments, solution, effective, known);
  Problem finer = problem.at_step(0.5 * problem.options().max_step);
  const Eigen::VectorXd error = kErrorOverChange * (solution.residual - finer.residual(solution.point, segments));
  Eigen::MatrixXd normal = solution.jacobian.transpose() * solution.jacobian;
  normal.diagonal() += prior_information(axes);
  const Eigen::VectorXd shift = damped_step(normal, solution.jacobian.transpose() * error, 0.0, least_curvatures(axes));
  double most = 0.0;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double size = coordinate_size(axes[a], solution.point[a]);
    most = std::max(most, std::fabs(shift(i)) / std::max(errors(i), kExact * size));
  }
  return most;
}

namespace {

/// Other starts: the best of them, as good as this one, in place of the present solution.
void look_elsewhere(Problem& problem, std::span<const int> train, const IdentifyOptions& options,
                    const LeastSquaresOptions& finish, FitResult& fit) {
  const SearchSpace& space = problem.space();
  const bool known = noise_is_known(problem.experiment());
  std::vector<LeastSquaresResult> ends{fit.solution};
  const double samples = static_cast<double>(fit.solution.residual.size());
  if (options.optimizer != Optimizer::lsq && !(known && down_to_noise(fit.solution.sum_of_squares, samples))) {
    try {
      ends.push_back(solve_least_squares(problem, space.start(), train, finish));
      fit.evaluations += ends.back().evaluations;
    } catch (const WorkError&) {
      // The scenario's own start cannot be simulated: the search found one that can.
    }
  }
  SeveralStarts found = from_several_starts(problem, train, std::move(ends), known, options.genetic.seed, finish);
  fit.solution = std::move(found.best);
  fit.arrived = found.arrived;
  fit.doubt = found.doubt;
  fit.evaluations += found.evaluations;
}

/// Where a model leaves more than the noise, the starts' errors are that much smaller beside what it leaves.
void hold_against_rest(Experiment& experiment, const LeastSquaresResult& fit) {
  const double over_noise = std::sqrt(fit.sum_of_squares / static_cast<double>(fit.residual.size()));
  for (Segment& segment : experiment.segments)
    if (segment.start_effects && over_noise > 1.0)
      segment.start_effects = std::make_shared<StartEffects>(StartEffects{segment.start_effects->columns / over_noise});
}

}  // namespace

FitResult identify(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                   const IdentifyOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<int> train = experiment.with_role(Role::train);
  if (train.empty()) throw WorkError("no recording has the role train: nothing to identify from");
  FitResult fit;
  fit.engine = options.simulator.engine;
  fit.optimizer = to_string(options.optimizer);
  SimulatorOptions simulator = options.simulator;
  fit.step = options.step ? StepChoice{*options.step, std::nan("")}
                          : choose_step(model, experiment, simulator, space.expand(space.start()));
  simulator.max_step = fit.step.step;
  const std::vector<double> weights = first_weights(model, experiment);
  std::optional<Problem> problem(std::in_place, model, experiment, space, simulator, weights);
  std::vector<double> start = space.start();
  if (options.optimizer != Optimizer::lsq && space.size() > 0) {
    const OptimizerResult found = search_population(*problem, options, train);
    if (found.interrupted) throw Interrupted();
    if (!std::isfinite(found.best_cost)) throw WorkError("every simulation of the search diverged");
    fit.history = found.history;
    fit.search_cost = found.best_cost;
    fit.evaluations += found.evaluations;
    start = found.best;
  }
  LeastSquaresOptions finish;
  finish.control = options.control;
  const bool refine = options.optimizer == Optimizer::lsq || options.optimizer == Optimizer::ga_lsq;
  if (!refine) finish.iterations = 0, finish.polish = false;
  if (options.tolerance) finish.tolerance = *options.tolerance, finish.polish = false;
  for (bool first = true;; first = false) {
    fit.solution = solve_least_squares(*problem, start, train, finish);
    if (first && refine && !options.tolerance && space.size() > 0)
      look_elsewhere(*problem, train, options, finish, fit);
    fit.point = fit.solution.point;
    fit.evaluations += fit.solution.evaluations;
    fit.values = space.expand(fit.point);
    if (!refine || options.step) break;
    // The plant may be stiffer as identified than as it was guessed.
    const StepChoice needed = choose_step(model, experiment, simulator, fit.values);
    fit.step = {std::min(needed.step, simulator.max_step), needed.error_over_noise};
    if (!(needed.step < simulator.max_step)) break;
    simulator.max_step = needed.step;
    problem.emplace(model, experiment, space, simulator, weights);
    start = fit.point;
  }
  Experiment with_errors = experiment;
  if (options.start_errors && refine && space.size() > 0 &&
      attach_start_effects(with_errors, model, simulator, fit.values)) {
    hold_against_rest(with_errors, fit.solution);
    problem.emplace(model, with_errors, space, simulator, weights);
    fit.solution = solve_least_squares(*problem, fit.point, train, finish);
    fit.point = fit.solution.point;
    fit.evaluations += fit.solution.evaluations;
    fit.values = space.expand(fit.point);
  }
  describe_fit(model, space, *problem, train, fit);
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    fit.rms.emplace_back(role, residual_rms(*problem, fit.values, role));
  }
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

double entry_of(const JointRms& rms, const std::string& joint) {
  for (const auto& [name, value] : rms) {
    if (name == joint) return value;
  }
  return std::nan("");
}

double over_noise(const JointRms& rms, const JointRms& noise) {
  double sum = 0.0;
  int n = 0;
  for (const auto& [joint, value] : rms) {
    const double ratio = value / entry_of(noise, joint);
    if (!std::isfinite(ratio)) continue;
    sum += ratio * ratio;
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : std::nan("");
}

}  // namespace lacuna
