// Noise and discrepancy: what a model leaves of each channel, as one stationary coloured process.
//
// y = f(theta) + delta + epsilon. What nobody modelled (delta) is slow beside the sensor's noise (epsilon): taken for
// white noise it would count every sample as news. Both together are an autoregressive process of order at most 8,
// fitted to the residual of the richest hypothesis that stands; every rival is weighed with that same covariance C.
// Where a model is exact the order goes to 0, and everything is as with white noise.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ga/problem.h"

namespace lacuna {

class Colour {
 public:
  static constexpr int kMostOrders = 8;

  /// From residual rows and their blocks: autocovariances of each channel over all its blocks, Levinson's recursion,
  /// the order by Schwarz's criterion. `floor`: rms of each channel's noise in the rows' unit, under which no
  /// innovation lies; NaN or 0: unknown.
  Colour(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks, std::span<const double> floor);

  /// C^(-1/2) times the rows, block by block: innovations over their rms. The first ones of a block are predicted from
  /// what there is of it.
  void whiten(Eigen::Ref<Eigen::MatrixXd> rows, std::span<const ResidualBlock> blocks) const;

  /// Samples over which a channel's residual forgets itself: the sum of its autocorrelations, at least 1.
  double correlation_samples(int channel) const;

 private:
  struct Channel {
    /// [order][lag - 1]: predictors of every order up to the chosen one; deviation[order]: rms of what they miss.
    std::vector<std::vector<double>> predictors{{}};
    std::vector<double> deviations{1.0};
    double memory = 1.0;
  };
  std::vector<Channel> channels_;
};

}  // namespace lacuna
