#include "study/identifiability.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "ga/identify.h"
#include "physics/course.h"

namespace lacuna {
namespace {

constexpr double kChiSquare95of2 = 5.991464547107979;  // chi-square with two degrees of freedom, 95 %
constexpr double kGram = 1e-3;                         // kg
constexpr double kSettle = 10.0;                       // s, one round of waiting for rest
constexpr int kSettleRounds = 20;
constexpr double kAtRest = 1e-7;  // rad (m) moved in a round
constexpr int kBoundary = 96;     // points of an ellipse

bool is_mass(const Trial& trial, std::size_t coordinate) { return trial.box.names[coordinate].ends_with(".mass"); }

/// d combination / d coordinate, central differences; rows in the order of combinations().
Eigen::MatrixXd combination_slopes(const Trial& trial, std::span<const double> point, std::size_t rows) {
  Eigen::MatrixXd out(rows, point.size());
  for (std::size_t i = 0; i < point.size(); ++i) {
    const double step = 1e-6 * coordinate_size(point[i], trial.box.lower[i], trial.box.upper[i]);
    std::vector<double> up(point.begin(), point.end()), down = up;
    up[i] += step, down[i] -= step;
    const auto a = combinations(trial, up), b = combinations(trial, down);
    for (std::size_t k = 0; k < rows; ++k) out(k, i) = (a[k].value - b[k].value) / (2.0 * step);
  }
  return out;
}

Ellipse ellipse_of(const std::string& x_name, const std::string& x_unit, double x, const std::string& y_name,
                   const std::string& y_unit, double y, const Eigen::Matrix2d& covariance) {
  Ellipse out{x_name, y_name, x_unit, y_unit, x, y, {}, {}};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  for (int k = 0; k <= kBoundary; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kBoundary;
    const Eigen::Vector2d round(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d at =
        eigen.eigenvectors() * (kChiSquare95of2 * eigen.eigenvalues().cwiseMax(0.0)).cwiseSqrt().cwiseProduct(round);
    out.boundary_x.push_back(x + at(0));
    out.boundary_y.push_back(y + at(1));
  }
  return out;
}

/// Covariance of the coordinates where each is known beforehand as well as its bounds say (uniform: width^2 / 12).
/// Without that, what the data leave open but no bounds allow would blur what they determine.
Eigen::MatrixXd covariance_within_bounds(const Trial& trial, const Eigen::MatrixXd& jacobian) {
  const Eigen::VectorXd deviation = bound_deviations(trial);
  const Eigen::MatrixXd scaled = jacobian * deviation.asDiagonal();
  const Eigen::Index n = jacobian.cols();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled + identity).ldlt().solve(identity);
  return deviation.asDiagonal() * inverse * deviation.asDiagonal();
}

/// Errors of the combinations by the delta method.
void assess_combinations(const Trial& trial, std::span<const double> point, const Eigen::MatrixXd& jacobian,
                         Excitation& out) {
  out.combinations = combinations(trial, point);
  if (out.combinations.empty()) return;
  const Eigen::MatrixXd slopes = combination_slopes(trial, point, out.combinations.size());
  const Eigen::MatrixXd covariance = slopes * covariance_within_bounds(trial, jacobian) * slopes.transpose();
  for (std::size_t k = 0; k < out.combinations.size(); ++k) {
    const double variance = covariance(k, k);
    out.combination_error.push_back(std::sqrt(std::max(variance, 0.0)) / std::fabs(out.combinations[k].value));
  }
  for (const auto& [i, j] :
       {std::pair<Eigen::Index, Eigen::Index>(0, 1), std::pair<Eigen::Index, Eigen::Index>(2, 3)}) {
    const std::vector<Eigen::Index> both{i, j};
    const Combination& a = out.combinations[i];
    const Combination& b = out.combinations[j];
    out.ellipses.push_back(ellipse_of(a.name, a.unit, a.value, b.name, b.unit, b.value, covariance(both, both)));
  }
}

}  // namespace

Eigen::VectorXd bound_deviations(const Trial& trial) {
  Eigen::VectorXd out(trial.box.lower.size());
  for (std::size_t i = 0; i < trial.box.lower.size(); ++i)
    out(i) = (trial.box.upper[i] - trial.box.lower[i]) / std::sqrt(12.0);
  return out;
}

Eigen::MatrixXd sensitivities(const Task& task, std::span<const double> point) {
  const Trial& trial = task.trial;
  Problem problem(*trial.model, task.experiment, task.space, task.simulator, task.weights);
  const std::vector<double> inner = inner_point(task, point);
  const Eigen::VectorXd at = problem.residual(inner, task.train);
  const Eigen::MatrixXd moving = problem.jacobian(inner, at, task.train);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(moving.rows(), point.size());
  for (std::size_t i = 0, k = 0; i < point.size(); ++i) {
    if (trial.axes[i].parameter >= 0) out.col(i) = moving.col(k++);
  }
  return out;
}

Excitation assess(const Task& task, std::span<const double> point, const std::string& name, bool total_mass_known) {
  const Trial& trial = task.trial;
  Eigen::MatrixXd jacobian = sensitivities(task, point);
  Excitation out;
  out.name = name;
  out.parameters = static_cast<int>(point.size());
  assess_combinations(trial, point, jacobian, out);
  std::vector<bool> moves;
  for (Eigen::Index i = 0; i < jacobian.cols(); ++i) moves.push_back(jacobian.col(i).squaredNorm() > 0.0);
  if (total_mass_known) {
    out.assumption = "total mass known";
    jacobian.conservativeResize(jacobian.rows() + 1, Eigen::NoChange);
    for (std::size_t i = 0; i < point.size(); ++i)
      jacobian(jacobian.rows() - 1, i) = is_mass(trial, i) ? 1.0 / kGram : 0.0;
  }
  Eigen::VectorXd sizes(jacobian.cols());
  for (std::size_t i = 0; i < point.size(); ++i)
    sizes(i) = coordinate_size(point[i], trial.box.lower[i], trial.box.upper[i]);
  const Identifiability known = identifiability(sizes, jacobian, 1.0, 1.0);
  out.rank = known.rank;
  const bool all_move = std::all_of(moves.begin(), moves.end(), [](bool x) { return x; });
  out.condition = all_move || total_mass_known ? known.condition : HUGE_VAL;
  const std::vector<double> values = parameter_values(trial, point);
  for (std::size_t i = 0; i < point.size(); ++i)
    out.knowledge.push_back({trial.box.names[i], trial.units[i], values[i], known.relative_error[i], moves[i]});
  for (const auto& direction : known.undetermined)
    out.undetermined.push_back(combination_in_words(direction.weights, trial.box.names));
  if (point.size() < 2) return out;
  // The first two parameters as they are: where they are tied together, a sliver.
  const std::vector<Eigen::Index> first{0, 1};
  out.ellipses.push_back(ellipse_of(trial.box.names[0], trial.units[0], point[0], trial.box.names[1], trial.units[1],
                                    point[1], known.covariance(first, first)));
  return out;
}

std::vector<double> rest_position(const Trial& trial, std::span<const double> values) {
  const std::vector<double> measured = trial.experiment.segments[trial.experiment.with_role(Role::train).front()].q0;
  const CommandTrack still = step_commands(trial, std::vector<double>(measured.size(), 0.0), kSettle);
  SimulatorOptions options;
  options.max_step = trial.step.step;
  const std::vector<std::vector<double>> one{std::vector<double>(values.begin(), values.end())};
  const std::vector<int> segments{0};
  std::vector<double> at = measured;
  for (int round = 0; round < kSettleRounds; ++round) {
    double moved = 0.0;
    const Experiment experiment = commanded(trial.experiment, still, at);
    make_simulator(*trial.model, experiment, options)->run(one, segments, [&](int, int, const auto& predicted) {
      for (std::size_t c = 0; c < predicted.size(); ++c) {
        if (experiment.channels[c].kind != ChannelKind::position) continue;
        double& q = at[experiment.channels[c].joint];
        const double end = predicted[c].back();
        moved = std::isfinite(end) ? std::max(moved, std::fabs(end - q)) : HUGE_VAL;
        q = end;
      }
    });
    if (moved < kAtRest) return at;
  }
  return measured;
}

CommandTrack step_commands(const Trial& trial, std::span<const double> volts, double seconds) {
  CommandTrack out = still_commands(volts.size(), seconds, trial.experiment.sample_period);
  for (std::size_t j = 0; j < volts.size(); ++j) {
    for (std::size_t k = 0; k < out.time.size(); ++k) out.value[j][k] = out.time[k] < kRestBefore ? 0.0 : volts[j];
  }
  return out;
}

std::vector<Excitation> assess_all(const Trial& trial) {
  const std::vector<double> point = trial.truth.value_or(trial.start);
  const Task task = make_task(trial, "featherstone", nullptr);
  std::vector<std::pair<std::string, Task>> motions;
  std::vector<std::string> files;
  for (const Segment& segment : trial.experiment.segments) {
    if (std::find(files.begin(), files.end(), segment.file) != files.end()) continue;
    files.push_back(segment.file);
    Experiment alone = trial.experiment;
    std::erase_if(alone.segments, [&](const Segment& s) { return s.file != segment.file; });
    for (Segment& s : alone.segments) s.role = Role::train;
    motions.emplace_back(segment.file, make_task(trial, alone, std::nullopt, "featherstone", nullptr));
  }
  if (std::holds_alternative<FreeRun>(trial.scenario.prediction)) {
    std::vector<double> volts(trial.model->dof(), 0.0);
    for (const Segment& segment : trial.experiment.segments) {
      for (std::size_t j = 0; j < volts.size(); ++j) {
        for (const double u : segment.commands->value[j]) volts[j] = std::max(volts[j], std::fabs(u));
      }
    }
    const double seconds = trial.experiment.span;
    motions.emplace_back("step", make_task(trial,
                                           commanded(trial.experiment, step_commands(trial, volts, seconds),
                                                     rest_position(trial, model_values(trial, point))),
                                           std::nullopt, "featherstone", nullptr));
  }
  bool any_mass = false;
  for (std::size_t i = 0; i < point.size(); ++i) any_mass = any_mass || is_mass(trial, i);
  std::vector<Excitation> out;
  for (auto& [name, motion] : motions) {
    motion.weights = trial.weights;
    out.push_back(assess(motion, point, name, false));
    if (any_mass) out.push_back(assess(motion, point, name, true));
  }
  return out;
}

}  // namespace lacuna
