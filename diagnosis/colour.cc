#include "diagnosis/colour.h"

#include <algorithm>
#include <cmath>

namespace lacuna {
namespace {

struct Autocovariance {
  std::vector<double> at;  ///< by lag from 0
  double samples = 0.0;
};

Autocovariance autocovariance(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks, int channel) {
  Autocovariance out{std::vector<double>(Colour::kMostOrders + 1, 0.0), 0.0};
  for (const ResidualBlock& block : blocks) {
    if (block.channel != channel) continue;
    const auto r = residual.segment(block.first, block.count);
    out.samples += static_cast<double>(block.count);
    for (Eigen::Index lag = 0; lag <= Colour::kMostOrders && lag < block.count; ++lag)
      out.at[lag] += r.head(block.count - lag).dot(r.tail(block.count - lag));
  }
  for (double& c : out.at) c /= std::max(out.samples, 1.0);
  return out;
}

}  // namespace

Colour::Colour(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks, std::span<const double> floor) {
  channels_.resize(floor.size());
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const Autocovariance cov = autocovariance(residual, blocks, static_cast<int>(c));
    const double least = floor[c] > 0.0 ? floor[c] * floor[c] : 0.0;
    if (!(cov.at[0] > 0.0)) continue;
    // Levinson and Durbin.
    std::vector<std::vector<double>> predictors{{}};
    std::vector<double> variances{cov.at[0]};
    for (int p = 1; p <= kMostOrders; ++p) {
      const std::vector<double>& last = predictors.back();
      double sum = cov.at[p];
      for (int i = 1; i < p; ++i) sum -= last[i - 1] * cov.at[p - i];
      const double reflection = sum / variances.back();
      if (!(std::fabs(reflection) < 1.0)) break;
      std::vector<double> next(p, reflection);
      for (int i = 1; i < p; ++i) next[i - 1] = last[i - 1] - reflection * last[p - i - 1];
      predictors.push_back(std::move(next));
      variances.push_back(variances.back() * (1.0 - reflection * reflection));
    }
    std::size_t best = 0;
    double least_cost = HUGE_VAL;
    for (std::size_t p = 0; p < variances.size(); ++p) {
      const double cost = cov.samples * std::log(variances[p]) + static_cast<double>(p) * std::log(cov.samples);
      if (cost < least_cost) least_cost = cost, best = p;
    }
    predictors.resize(best + 1), variances.resize(best + 1);
    Channel& channel = channels_[c];
    channel.predictors = predictors;
    channel.deviations.clear();
    for (const double v : variances) channel.deviations.push_back(std::sqrt(std::max(v, least)));
    // The spectrum at zero over its mean: how many samples say one thing.
    double gain = 1.0;
    for (const double a : predictors.back()) gain -= a;
    channel.memory = std::clamp(variances.back() / (gain * gain) / cov.at[0], 1.0, cov.samples);
  }
}

void Colour::whiten(Eigen::Ref<Eigen::MatrixXd> rows, std::span<const ResidualBlock> blocks) const {
  for (const ResidualBlock& block : blocks) {
    const Channel& channel = channels_[block.channel];
    const Eigen::Index order = static_cast<Eigen::Index>(channel.predictors.size()) - 1;
    for (Eigen::Index k = block.count - 1; k >= 0; --k) {  // backwards: what comes before is still as it was
      const std::size_t p = static_cast<std::size_t>(std::min(k, order));
      const std::vector<double>& a = channel.predictors[p];
      auto row = rows.row(block.first + k);
      for (std::size_t i = 0; i < p; ++i) row -= a[i] * rows.row(block.first + k - 1 - static_cast<Eigen::Index>(i));
      row /= channel.deviations[p];
    }
  }
}

double Colour::correlation_samples(int channel) const { return channels_[channel].memory; }

}  // namespace lacuna
