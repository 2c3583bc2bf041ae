#include "diff/side.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "ga/sandwich.h"

namespace lacuna {
namespace {

constexpr double kPinned = 1e-3;  ///< prior's standard deviations within which a pinned number is known

/// [row]: the recording that it comes from, counted from 0.
std::vector<int> recording_of_rows(std::span<const ResidualBlock> blocks, const Experiment& experiment,
                                   Eigen::Index rows) {
  std::map<std::string, int> files;
  std::vector<int> out(rows, 0);
  for (const ResidualBlock& b : blocks) {
    const std::string& file = experiment.segments[b.segment].file;
    const int number = files.emplace(file, static_cast<int>(files.size())).first->second;
    std::fill_n(out.begin() + b.first, b.count, number);
  }
  return out;
}

/// Variance of the summed scores along each direction, from how they scatter between clusters of rows.
Eigen::VectorXd score_variance(const Eigen::MatrixXd& along, const Eigen::VectorXd& residual,
                               const std::vector<int>& cluster) {
  const int count = cluster.empty() ? 0 : 1 + *std::max_element(cluster.begin(), cluster.end());
  if (count < 2) return Eigen::VectorXd::Zero(along.cols());
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(along.cols(), count);
  for (Eigen::Index row = 0; row < along.rows(); ++row)
    scores.col(cluster[row]) += residual(row) * along.row(row).transpose();
  const double few = static_cast<double>(count) / static_cast<double>(count - 1);
  return few * scores.rowwise().squaredNorm();
}

Eigen::VectorXd prior_sizes(const std::vector<Axis>& axes) {
  Eigen::VectorXd out(axes.size());
  for (std::size_t a = 0; a < axes.size(); ++a) out(a) = axes[a].prior;
  return out;
}

}  // namespace

Eigen::VectorXd in_priors(const Side& side, const std::vector<double>& point) {
  Eigen::VectorXd out(point.size());
  for (std::size_t a = 0; a < point.size(); ++a) out(a) = (point[a] - side.axes()[a].center) / side.axes()[a].prior;
  return out;
}

Eigen::VectorXd rows_at(const Side& side, const std::vector<double>& point, Role role) {
  const std::vector<int> segments = side.experiment.with_role(role);
  if (segments.empty()) return {};
  Problem problem = problem_of(side.model, side.context());
  return problem.residual(point, segments);
}

Quadratic information_about(const Side& side, const std::vector<double>& point, const Eigen::VectorXd& residual,
                            const Eigen::MatrixXd& jacobian) {
  const Problem problem = problem_of(side.model, side.context());
  const auto blocks = problem.layout(side.experiment.with_role(Role::train));
  const Eigen::MatrixXd J = jacobian * prior_sizes(side.axes()).asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(J.transpose() * J);
  const Eigen::MatrixXd& U = eigen.eigenvectors();
  const Eigen::VectorXd lambda = eigen.eigenvalues().cwiseMax(0.0);
  const Eigen::MatrixXd along = J * U;
  const double memory = static_cast<double>(residual.size()) / std::max(1.0, effective_samples(residual, blocks));
  const Eigen::VectorXd scatter =
      score_variance(along, residual, time_blocks(blocks, memory))
          .cwiseMax(score_variance(along, residual, recording_of_rows(blocks, side.experiment, residual.size())));
  Eigen::VectorXd kept(lambda.size());  // share of the information
  for (Eigen::Index k = 0; k < lambda.size(); ++k)
    kept(k) = lambda(k) > 0.0 ? std::min(1.0, lambda(k) / std::max(scatter(k), 1e-300)) : 1.0;
  Quadratic out;
  out.information = U * (kept.cwiseProduct(lambda)).asDiagonal() * U.transpose();
  const Eigen::VectorXd gradient = U * kept.asDiagonal() * (along.transpose() * residual);
  const Eigen::VectorXd y = in_priors(side, point);
  out.linear = out.information * y - gradient;
  for (const auto& [axis, value] : side.pins) {
    const auto i = static_cast<Eigen::Index>(axis);
    const double weight = 1.0 / (kPinned * kPinned);
    out.information(i, i) += weight;
    out.linear(i) += weight * (value - side.axes()[axis].center) / side.axes()[axis].prior;
  }
  return out;
}

Quadratic information_at(const Side& side, const std::vector<double>& point) {
  const std::vector<int> train = side.experiment.with_role(Role::train);
  Problem problem = problem_of(side.model, side.context());
  const Eigen::VectorXd residual = problem.residual(point, train);
  return information_about(side, point, residual, problem.jacobian(point, residual, train));
}

}  // namespace lacuna
