#include "ga/sandwich.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace lacuna {
namespace {

constexpr double kBlockMemories = 5.0;  ///< correlation times that a block spans at least
constexpr Eigen::Index kLeastBlocks = 10, kMostBlocks = 40;

}  // namespace

std::vector<int> time_blocks(std::span<const ResidualBlock> blocks, double correlation) {
  std::map<int, Eigen::Index> first;  // of every segment, all segments one after the other
  Eigen::Index rows = 0;
  for (const ResidualBlock& b : blocks) {
    Eigen::Index& count = first[b.segment];
    count = std::max(count, b.count);
    rows = std::max(rows, b.first + b.count);
  }
  Eigen::Index total = 0;
  for (auto& [segment, count] : first) total += std::exchange(count, total);
  const auto wanted = static_cast<Eigen::Index>(std::ceil(kBlockMemories * correlation));
  const Eigen::Index length = std::max({Eigen::Index{1}, total / kMostBlocks, std::min(wanted, total / kLeastBlocks)});
  std::vector<int> out(rows, 0);
  for (const ResidualBlock& b : blocks) {
    for (Eigen::Index k = 0; k < b.count; ++k) out[b.first + k] = static_cast<int>((first[b.segment] + k) / length);
  }
  return out;
}

Eigen::VectorXd sandwich_errors(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& jacobian,
                                const Eigen::VectorXd& residual, std::span<const int> block) {
  const int count = block.empty() ? 0 : 1 + *std::max_element(block.begin(), block.end());
  if (count < 2) return Eigen::VectorXd::Zero(jacobian.cols());
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(jacobian.cols(), count);
  for (std::size_t row = 0; row < block.size(); ++row) {
    const auto k = static_cast<Eigen::Index>(row);
    scores.col(block[row]) += residual(k) * jacobian.row(k).transpose();
  }
  const double few = static_cast<double>(count) / static_cast<double>(count - 1);
  return std::sqrt(few) * (covariance * scores).rowwise().norm();
}

}  // namespace lacuna
