#include "ga/least_squares.h"

#include <ceres/ceres.h>

#include <Eigen/SVD>
#include <cmath>

#include "scenarios/error.h"

namespace lacuna {
namespace {

/// A direction whose standard error exceeds its own size is not determined by the data.
constexpr double kUndetermined = 1.0;

/// Chi-square units: a step that lowers the cost by less is below anything that statistics could see.
constexpr double kLikelihoodShare = 0.05;

/// The stacked residual as one Ceres cost function over one parameter block.
class ResidualCost final : public ceres::CostFunction {
 public:
  ResidualCost(Problem& problem, std::span<const int> segments, Eigen::Index rows)
      : problem_(problem), segments_(segments) {
    set_num_residuals(static_cast<int>(rows));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.space().size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::vector<double> point(parameters[0], parameters[0] + problem_.space().size());
    if (point != last_point_) {
      last_ = problem_.residual(point, segments_);
      last_point_ = point;
      ++evaluations;
    }
    if (!last_.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, last_.size()) = last_;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Eigen::MatrixXd J = problem_.jacobian(point, last_, segments_);
    evaluations += J.cols();
    if (!J.allFinite()) return false;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(jacobians[0], J.rows(), J.cols()) = J;
    return true;
  }

  mutable long evaluations = 0;

 private:
  Problem& problem_;
  std::span<const int> segments_;
  mutable std::vector<double> last_point_;
  mutable Eigen::VectorXd last_;
};

/// Progress, and a clean end when the user interrupts.
class Watch final : public ceres::IterationCallback {
 public:
  explicit Watch(const LeastSquaresOptions& options) : options_(options) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const RunControl& control = options_.control;
    if (control.progress) {
      control.progress({"least squares", static_cast<double>(summary.iteration) / options_.iterations,
                        2.0 * summary.cost, 0});
    }
    if (control.stop != nullptr && *control.stop) return ceres::SOLVER_ABORT;
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const LeastSquaresOptions& options_;
};

/// Start pulled a hair inside the bounds: Ceres needs a feasible point.
std::vector<double> inside(const SearchSpace& space, std::vector<double> point) {
  for (std::size_t a = 0; a < point.size(); ++a) {
    point[a] = std::clamp(point[a], space.axes()[a].lower, space.axes()[a].upper);
  }
  return point;
}

}  // namespace

LeastSquaresResult solve_least_squares(Problem& problem, const std::vector<double>& start,
                                       std::span<const int> segments, const LeastSquaresOptions& options) {
  LeastSquaresResult result;
  result.point = inside(problem.space(), start);
  const auto blocks = problem.layout(segments);
  const Eigen::Index rows = blocks.empty() ? 0 : blocks.back().first + blocks.back().count;
  if (!problem.residual(result.point, segments).allFinite()) {
    throw WorkError("the simulation diverges at the start values: no least-squares fit can begin there");
  }
  if (problem.space().size() > 0) {
    ceres::Problem solver;
    auto* cost = new ResidualCost(problem, segments, rows);  // owned by `solver`
    solver.AddResidualBlock(cost, nullptr, result.point.data());
    for (std::size_t a = 0; a < result.point.size(); ++a) {
      solver.SetParameterLowerBound(result.point.data(), static_cast<int>(a), problem.space().axes()[a].lower);
      solver.SetParameterUpperBound(result.point.data(), static_cast<int>(a), problem.space().axes()[a].upper);
    }
    ceres::Solver::Options settings;
    settings.max_num_iterations = options.iterations;
    settings.function_tolerance = std::max(options.tolerance, kLikelihoodShare / static_cast<double>(rows));
    settings.initial_trust_region_radius = 1e8;  // near Gauss-Newton: the start is a search's best or a neighbour's fit
    settings.parameter_tolerance = 1e-10;
    settings.gradient_tolerance = 1e-14;
    settings.linear_solver_type = ceres::DENSE_QR;
    settings.num_threads = 1;
    settings.logging_type = ceres::SILENT;
    Watch watch(options);
    settings.callbacks.push_back(&watch);
    settings.update_state_every_iteration = false;
    ceres::Solver::Summary summary;
    ceres::Solve(settings, &solver, &summary);
    if (summary.termination_type == ceres::USER_FAILURE) throw Interrupted();
    result.iterations = static_cast<int>(summary.iterations.size());
    result.evaluations = cost->evaluations;
    result.converged = summary.termination_type == ceres::CONVERGENCE;
  }
  result.residual = problem.residual(result.point, segments);
  result.jacobian = problem.jacobian(result.point, result.residual, segments);
  result.sum_of_squares = result.residual.squaredNorm();
  return result;
}

double effective_samples(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks) {
  double total = 0.0;
  for (const ResidualBlock& block : blocks) {
    const Eigen::Index n = block.count;
    if (n < 8) {
      total += static_cast<double>(n);
      continue;
    }
    const Eigen::VectorXd r = residual.segment(block.first, n).array() - residual.segment(block.first, n).mean();
    const double variance = r.squaredNorm() / static_cast<double>(n);
    if (!(variance > 0.0)) {
      total += static_cast<double>(n);
      continue;
    }
    auto correlation = [&](Eigen::Index lag) {
      return r.head(n - lag).dot(r.tail(n - lag)) / (static_cast<double>(n) * variance);
    };
    double sum = 1.0;
    for (Eigen::Index lag = 1; lag + 1 < n / 2; lag += 2) {
      const double pair = correlation(lag) + correlation(lag + 1);
      if (pair <= 0.0) break;
      sum += 2.0 * pair;
    }
    total += std::min(static_cast<double>(n), static_cast<double>(n) / sum);
  }
  return std::max(total, 1.0);
}

Identifiability identifiability(const SearchSpace& space, const std::vector<double>& point,
                                const Eigen::MatrixXd& jacobian, double variance, double samples_share) {
  Identifiability out;
  const Eigen::Index n = jacobian.cols();
  if (n == 0) return out;
  Eigen::VectorXd size(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const Axis& axis = space.axes()[static_cast<std::size_t>(a)];
    const double value = std::fabs(point[static_cast<std::size_t>(a)]);
    const double range = axis.upper - axis.lower;
    size(a) = value > 1e-3 * range || !std::isfinite(range) ? std::max(value, 1e-12) : range;
  }
  const Eigen::MatrixXd scaled = jacobian * size.asDiagonal();
  // The normal matrix has the singular values squared; sizes are scaled, so double precision resolves what matters.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  const double scale = variance / std::max(samples_share, 1e-12);
  const double largest = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double value = std::max(eigen.eigenvalues()(k), 1e-15 * largest);
    const double error = std::sqrt(scale / value);
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
    covariance += error * error * direction * direction.transpose();
    if (error < kUndetermined) {
      ++out.rank;
    } else {
      out.undetermined.push_back({error, {direction.data(), direction.data() + n}});
    }
  }
  out.condition = std::sqrt(largest / std::max(eigen.eigenvalues().minCoeff(), 1e-15 * largest));
  for (Eigen::Index a = 0; a < n; ++a) out.relative_error.push_back(std::sqrt(covariance(a, a)));
  out.covariance = size.asDiagonal() * covariance * size.asDiagonal();
  return out;
}

}  // namespace lacuna
