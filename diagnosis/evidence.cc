#include "diagnosis/evidence.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>

#include "ga/least_squares.h"
#include "ga/random.h"

namespace lacuna {
namespace {

constexpr double kSingular = 1e-8;  ///< of a unit normal matrix: directions less determined count as determined so
constexpr int kFewestBlocks = 20;
constexpr double kFamilyError = 1e-3;  ///< chance of any joint flagged on well-specified data
constexpr double kNegligible = 0.05;   ///< excess variance under this share of the noise's is not mentioned
constexpr int kResamples = 400;

std::map<int, std::vector<ResidualBlock>> by_channel(std::span<const ResidualBlock> blocks) {
  std::map<int, std::vector<ResidualBlock>> out;
  for (const ResidualBlock& block : blocks) out[block.channel].push_back(block);
  return out;
}

}  // namespace

double Gain::at(const Gain& reference) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < channels.size() && c < reference.channels.size(); ++c) {
    sum += 0.5 * reference.channels[c].effective * channels[c].log_ratio;
  }
  return sum;
}

Gain residual_gain(const Eigen::VectorXd& before, const Eigen::VectorXd& after, std::span<const ResidualBlock> blocks) {
  Gain out;
  double energy_before = 0.0, energy_after = 0.0;
  for (const auto& [channel, members] : by_channel(blocks)) {
    double a = 0.0, b = 0.0;
    for (const ResidualBlock& block : members) {
      a += before.segment(block.first, block.count).squaredNorm();
      b += after.segment(block.first, block.count).squaredNorm();
    }
    out.channels.push_back({});
    if (!(a > 0.0) || !(b > 0.0)) continue;
    const double n = effective_samples(after, members);
    out.channels.back() = {n, std::log(a / b)};
    out.log_likelihood += 0.5 * n * std::log(a / b);
    out.effective += n;
    energy_before += a;
    energy_after += b;
  }
  out.share = energy_before > 0.0 ? 1.0 - energy_after / energy_before : 0.0;
  return out;
}

namespace {

/// Each block's own logarithm of energies: a few seconds in which the plain model goes far astray do not decide alone.
std::vector<double> block_gains(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                std::span<const ResidualBlock> blocks) {
  std::map<int, Eigen::Index> samples;  // per segment
  Eigen::Index total = 0;
  for (const ResidualBlock& block : blocks) {
    if (samples.emplace(block.segment, block.count).second) total += block.count;
  }
  const Eigen::Index length = std::max<Eigen::Index>(1, std::min<Eigen::Index>(100, total / kFewestBlocks));
  std::map<std::pair<int, Eigen::Index>, double> sums;
  for (const ResidualBlock& block : blocks) {
    for (Eigen::Index first = 0; first < block.count; first += length) {
      const Eigen::Index n = std::min(length, block.count - first);
      const double a = before.segment(block.first + first, n).squaredNorm();
      const double b = after.segment(block.first + first, n).squaredNorm();
      if (a > 0.0 && b > 0.0) sums[{block.segment, first / length}] += 0.5 * static_cast<double>(n) * std::log(a / b);
    }
  }
  std::vector<double> out;
  for (const auto& [key, sum] : sums) out.push_back(sum);
  return out;
}

}  // namespace

Eigen::MatrixXd prediction_spread(const Eigen::MatrixXd& fitted, const Eigen::VectorXd& residual,
                                  std::span<const ResidualBlock> blocks, const Eigen::MatrixXd& elsewhere,
                                  const Eigen::VectorXd& floor) {
  if (fitted.cols() == 0) return {};
  const Eigen::MatrixXd normal = fitted.transpose() * fitted;
  const Eigen::VectorXd scale = column_scales(normal);
  Eigen::MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  unit.diagonal() = scale.cwiseAbs2().cwiseProduct(floor).array() + (1.0 + kSingular);
  const double variance = residual.squaredNorm() / effective_samples(residual, blocks);
  // normal^-1 = (S R^-1) (S R^-1)^T with S the scales and R^T R = unit.
  const Eigen::MatrixXd scaled = std::sqrt(variance) * elsewhere * scale.asDiagonal();
  return unit.llt().matrixU().solve<Eigen::OnTheRight>(scaled);
}

HeldoutGain heldout_gain(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                         std::span<const ResidualBlock> blocks, const Eigen::MatrixXd& spread) {
  HeldoutGain out;
  if (blocks.empty() || !after.allFinite()) return out;
  out.whole = residual_gain(before, after, blocks);
  out.gain = out.whole.log_likelihood;
  out.share = out.whole.share;
  out.blocks = block_gains(before, after, blocks);
  double product = 0.0, variance = 0.0, error = 0.0;
  Eigen::VectorXd through = Eigen::VectorXd::Zero(spread.cols());  // d, weighed, times the spread
  std::size_t index = 0;
  for (const auto& [channel, members] : by_channel(blocks)) {
    double a = 0.0, b = 0.0, along = 0.0, change = 0.0;
    for (const ResidualBlock& block : members) {
      const auto r = before.segment(block.first, block.count), rest = after.segment(block.first, block.count);
      a += r.squaredNorm(), b += rest.squaredNorm();
      along += (r - rest).dot(r), change += (r - rest).squaredNorm();
    }
    const double n = out.whole.channels[index++].effective;
    if (!(a > 0.0) || !(b > 0.0)) continue;
    product += n * along / b;
    variance += n * change / b;
    error += n * change * b / (a * a);
    for (const ResidualBlock& block : members) {
      if (spread.cols() == 0) break;
      const auto r = before.segment(block.first, block.count), rest = after.segment(block.first, block.count);
      through += n / b * (spread.middleRows(block.first, block.count).transpose() * (r - rest));
    }
  }
  variance += through.squaredNorm();
  if (!(variance > 0.0)) return out;
  out.error = std::sqrt(error);
  out.standard_errors = product / std::sqrt(variance);
  // As far as a double holds the chance.
  out.p_value =
      boost::math::cdf(boost::math::complement(boost::math::normal(), std::clamp(out.standard_errors, -35.0, 35.0)));
  return out;
}

double chance(double gain, int parameters, int tries) {
  if (!(gain > 0.0)) return 1.0;
  const boost::math::chi_squared law(parameters);
  return std::min(1.0, tries * boost::math::cdf(boost::math::complement(law, std::min(2.0 * gain, 1e8))));
}

double chance(double gain, int parameters, const HeldoutGain& heldout, int tries) {
  const double product = chance(gain, parameters, 1) * heldout.p_value;
  if (!(product > 0.0)) return 0.0;
  return std::min(1.0, tries * product * (1.0 - std::log(product)));  // the tail of chi-square with four numbers
}

double stability(std::span<const double> first, std::span<const double> second, std::uint64_t seed) {
  if (first.empty() || first.size() != second.size()) return 0.0;
  int wins = 0;
  for (int k = 0; k < kResamples; ++k) {
    RandomStream random(seed, static_cast<std::uint32_t>(k), 0);
    double sum = 0.0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const std::size_t pick = random.below(static_cast<std::uint32_t>(first.size()));
      sum += first[pick] - second[pick];
    }
    wins += sum > 0.0;
  }
  return static_cast<double>(wins) / kResamples;
}

double chance_of_energy(double ratio, double n) {
  if (!std::isfinite(ratio)) return 0.0;  // a model that diverges
  const double z = (std::cbrt(ratio) - (1.0 - 2.0 / (9.0 * n))) / std::sqrt(2.0 / (9.0 * n));
  return boost::math::cdf(boost::math::complement(boost::math::normal(), std::min(z, 35.0)));
}

std::vector<ExcessNoise> excess_over_noise(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks,
                                           std::span<const double> noise_over_weight) {
  std::vector<ExcessNoise> all;
  for (std::size_t c = 0; c < noise_over_weight.size(); ++c) {
    std::vector<ResidualBlock> members;
    double sum = 0.0, count = 0.0;
    for (const ResidualBlock& block : blocks) {
      if (block.channel != static_cast<int>(c)) continue;
      members.push_back(block);
      sum += residual.segment(block.first, block.count).squaredNorm();
      count += static_cast<double>(block.count);
    }
    const double noise = noise_over_weight[c];
    if (!(noise > 0.0) || count < 1.0) continue;
    const double n = effective_samples(residual, members), ratio = sum / (count * noise * noise);
    all.push_back({static_cast<int>(c), std::sqrt(ratio), chance_of_energy(ratio, n)});
  }
  std::sort(all.begin(), all.end(), [](const ExcessNoise& a, const ExcessNoise& b) { return a.p_value < b.p_value; });
  std::vector<ExcessNoise> out;
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].p_value = std::min(1.0, all[k].p_value * static_cast<double>(all.size() - k));
    if (all[k].p_value > kFamilyError) break;
    if (all[k].ratio * all[k].ratio > 1.0 + kNegligible) out.push_back(all[k]);
  }
  return out;
}

std::vector<Autocorrelation> autocorrelations(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks) {
  std::vector<Autocorrelation> out;
  for (const auto& [channel, members] : by_channel(blocks)) {
    double energy = 0.0, sum = 0.0;
    Autocorrelation found{channel, 0.0, std::vector<double>(kLags, 0.0), 1.0};
    for (const ResidualBlock& block : members) {
      const auto r = residual.segment(block.first, block.count);
      found.samples += static_cast<double>(block.count);
      energy += r.squaredNorm();
      for (Eigen::Index lag = 1; lag <= kLags && lag < block.count; ++lag)
        found.by_lag[lag - 1] += r.head(block.count - lag).dot(r.tail(block.count - lag));
    }
    if (!(energy > 0.0) || !std::isfinite(energy) || found.samples <= 2 * kLags) continue;
    const double n = found.samples;
    for (int lag = 1; lag <= kLags; ++lag) {
      const double rho = found.by_lag[lag - 1] /= energy;
      sum += n * (n + 2.0) * rho * rho / (n - lag);
    }
    const boost::math::chi_squared law(kLags);
    found.p_value = boost::math::cdf(boost::math::complement(law, std::min(sum, 1e6)));
    out.push_back(std::move(found));
  }
  return out;
}

double chance_of_white(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks) {
  const std::vector<Autocorrelation> channels = autocorrelations(residual, blocks);
  double least = 1.0;
  for (const Autocorrelation& channel : channels) least = std::min(least, channel.p_value);
  return std::min(1.0, least * static_cast<double>(channels.size()));
}

}  // namespace lacuna
