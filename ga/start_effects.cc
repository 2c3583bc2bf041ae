#include "ga/start_effects.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

namespace lacuna {
namespace {

constexpr double kNegligibleError = 2.0;  ///< squared change over noise, summed over a segment, of one standard error
/// Of a pressure's noise: what it does to positions falls with the square of the order.
constexpr unsigned kPressureOrders = 4;
constexpr double kUsable = 1e-6;  ///< eigenvalue under which a direction is left alone

using Predictions = std::vector<Eigen::VectorXd>;  // by segment, rows as in StartEffects

Predictions predict(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options,
                    std::span<const double> values) {
  std::vector<int> segments(experiment.segments.size());
  for (std::size_t s = 0; s < segments.size(); ++s) segments[s] = static_cast<int>(s);
  Predictions out(segments.size());
  const std::vector<std::vector<double>> one{std::vector<double>(values.begin(), values.end())};
  make_simulator(model, experiment, options)->run(one, segments, [&](int, int s, const auto& predicted) {
    const Segment& segment = experiment.segments[s];
    std::vector<double> rows;
    for (std::size_t c = 0; c < predicted.size(); ++c)
      for (std::size_t k = 0; k < predicted[c].size(); ++k)
        if (std::isfinite(segment.measured[c][k])) rows.push_back(predicted[c][k]);
    out[s] = Eigen::Map<const Eigen::VectorXd>(rows.data(), rows.size());
  });
  return out;
}

/// Noise of each row of a segment.
Eigen::VectorXd row_noise(const Experiment& experiment, const Segment& segment) {
  std::vector<double> rows;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c)
    for (const double x : segment.measured[c])
      if (std::isfinite(x)) rows.push_back(experiment.channels[c].noise);
  return Eigen::Map<const Eigen::VectorXd>(rows.data(), rows.size());
}

bool has_noisy_pressure(const Experiment& experiment, std::size_t j, std::size_t which) {
  return !experiment.segments.empty() && experiment.segments.front().is_pressed(j) &&
         experiment.pressure_noise[j][which] > 0.0;
}

/// One standard error of the Legendre polynomial of that order in every segment's pressure. Of n samples of white noise
/// it is sqrt((2 order + 1)/n) of the noise. Segments of a recording share its track: they lie side by side.
Experiment with_pressure_error(const Experiment& experiment, std::size_t j, std::size_t which, unsigned order) {
  Experiment out = experiment;
  std::map<const PressureTrack*, std::shared_ptr<PressureTrack>> moved;
  for (Segment& s : out.segments) {
    std::shared_ptr<PressureTrack>& track = moved[s.pressures.get()];
    if (!track) track = std::make_shared<PressureTrack>(*s.pressures);
    const double n = static_cast<double>(s.count);
    const double size = experiment.pressure_noise[j][which] * std::sqrt((2.0 * order + 1.0) / n);
    for (std::size_t k = 0; k < s.count; ++k)
      (*track)[j][which][s.first + k] = (*s.pressures)[j][which][s.first + k] +
                                        size * std::legendre(order, 2.0 * static_cast<double>(k) / (n - 1.0) - 1.0);
    s.pressures = track;
  }
  return out;
}

/// One standard error of that chamber's pressure at the start of every segment where it was measured there; none where
/// its noise is unknown.
std::optional<Experiment> with_start_pressure_error(const Experiment& experiment, std::size_t j, std::size_t which) {
  const ChannelKind kind = which == 0 ? ChannelKind::pressure_a : ChannelKind::pressure_b;
  const auto channel = std::ranges::find_if(
      experiment.channels, [&](const Channel& c) { return c.kind == kind && c.joint == static_cast<int>(j); });
  if (channel == experiment.channels.end() || !(channel->noise > 0.0)) return std::nullopt;
  Experiment out = experiment;
  for (Segment& s : out.segments)
    if (!s.pressures0.empty()) s.pressures0[j][which] += channel->noise;  // stays NaN where it was not measured
  return out;
}

}  // namespace

bool attach_start_effects(Experiment& experiment, const PlantModel& model, const SimulatorOptions& options,
                          std::span<const double> values) {
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return false;
  const Predictions plain = predict(model, experiment, options, values);
  std::vector<std::vector<Eigen::VectorXd>> columns(experiment.segments.size());
  const auto add_columns = [&](const Experiment& moved) {
    const Predictions off = predict(model, moved, options, values);
    for (std::size_t s = 0; s < off.size(); ++s) {
      const Eigen::VectorXd column = off[s] - plain[s];
      const double size = column.cwiseQuotient(row_noise(experiment, experiment.segments[s])).squaredNorm();
      if (std::isfinite(size) && size > kNegligibleError) columns[s].push_back(column);
    }
  };
  for (std::size_t j = 0; j < experiment.joint_names.size(); ++j) {
    for (const bool speed : {false, true}) {
      Experiment moved = experiment;
      for (Segment& s : moved.segments) (speed ? s.v0 : s.q0)[j] += (speed ? s.v0_error : s.q0_error)[j];
      add_columns(moved);
    }
    for (const std::size_t which : {0u, 1u}) {
      if (const auto moved = with_start_pressure_error(experiment, j, which)) add_columns(*moved);
      for (unsigned order = 0; has_noisy_pressure(experiment, j, which) && order < kPressureOrders; ++order)
        add_columns(with_pressure_error(experiment, j, which, order));
    }
  }
  bool any = false;
  for (std::size_t s = 0; s < columns.size(); ++s) {
    if (columns[s].empty()) continue;
    auto effects = std::make_shared<StartEffects>();
    effects->columns.resize(plain[s].size(), columns[s].size());
    for (std::size_t k = 0; k < columns[s].size(); ++k) effects->columns.col(k) = columns[s][k];
    experiment.segments[s].start_effects = std::move(effects);
    any = true;
  }
  return any;
}

StartWhitening::StartWhitening(const Eigen::MatrixXd& effects, Eigen::VectorXd row_weights)
    : effects_(&effects), inverse_weights_(row_weights.cwiseInverse()) {
  if (effects.rows() != row_weights.size())
    throw std::invalid_argument("effects of a start on another number of samples");
  const Eigen::MatrixXd scaled = inverse_weights_.asDiagonal() * effects;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> of(scaled.transpose() * scaled);
  // Along an eigenvector of scaled scaled^T with eigenvalue l the residual shrinks to 1/sqrt(1 + l).
  Eigen::VectorXd less(of.eigenvalues().size()), more = less;
  for (Eigen::Index k = 0; k < less.size(); ++k) {
    const double l = of.eigenvalues()(k), root = std::sqrt(1.0 + std::max(l, 0.0));
    less(k) = l > kUsable ? (1.0 - 1.0 / root) / l : 0.0;
    more(k) = l > kUsable ? (root - 1.0) / l : 0.0;
  }
  shrinkage_ = of.eigenvectors() * less.asDiagonal() * of.eigenvectors().transpose();
  growth_ = of.eigenvectors() * more.asDiagonal() * of.eigenvectors().transpose();
}

void StartWhitening::apply(Eigen::Ref<Eigen::VectorXd> residual) const {
  if (effects_ == nullptr) return;
  const Eigen::VectorXd explained = shrinkage_ * (effects_->transpose() * residual.cwiseProduct(inverse_weights_));
  residual -= inverse_weights_.cwiseProduct(*effects_ * explained);
}

void StartWhitening::undo(Eigen::Ref<Eigen::VectorXd> whitened) const {
  if (effects_ == nullptr) return;
  const Eigen::VectorXd missing = growth_ * (effects_->transpose() * whitened.cwiseProduct(inverse_weights_));
  whitened += inverse_weights_.cwiseProduct(*effects_ * missing);
}

}  // namespace lacuna
