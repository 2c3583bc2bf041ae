// How well a fit determines its parameters where what it leaves is no white noise: a law that is not quite right leaves
// a rest that is slow, larger in some motions than in others, and shared by neighbouring windows.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ga/problem.h"

namespace lacuna {

/// Which of at most 40 stretches of time every residual row belongs to, all channels of a stretch together: each at
/// least five times as long as the residual remembers itself (`correlation`, samples), but no fewer than 10 in all.
std::vector<int> time_blocks(std::span<const ResidualBlock> blocks, double correlation);

/// Standard errors of a least-squares point, one a column: the square roots of the diagonal of C (sum_b g_b g_b^T) C,
/// g_b = J_b^T r_b summed over the rows of block b, C the covariance that white noise would give. They hold whatever
/// the residual's colour within blocks and wherever it is large. P. J. Huber, 5th Berkeley Symposium (1967); in
/// clusters: K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986). `block`: [row], from 0.
Eigen::VectorXd sandwich_errors(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& jacobian,
                                const Eigen::VectorXd& residual, std::span<const int> block);

}  // namespace lacuna
