#include "diagnosis/partial.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/candidates.h"

namespace lacuna {
namespace {

constexpr double kEstimateDamping = 1e-6;  // of the linear estimate, relative to the normal matrix' diagonal

std::vector<std::string> files_of(const Experiment& experiment, Role role) {
  std::vector<std::string> out;
  for (const int s : experiment.with_role(role)) {
    const std::string& file = experiment.segments[static_cast<std::size_t>(s)].file;
    if (std::find(out.begin(), out.end(), file) == out.end()) out.push_back(file);
  }
  return out;
}

}  // namespace

std::vector<std::string> likely_recordings(const CurrentModel& current, const Experiment& experiment,
                                           const CoarseLook& coarse, const EffectSpec& spec) {
  const std::vector<int> train = experiment.with_role(Role::train);
  const std::vector<std::string> files = files_of(experiment, Role::train);
  if (files.size() < 2) return {};
  const PlantModel model = current.model.with_effects({spec});
  const Component& component = model.effects().back();
  const Axis axis = effect_axes(model, experiment, component, spec).front();
  const ParameterInfo& info = *model.parameters()[static_cast<std::size_t>(axis.parameter)].info;
  const double size =
      info.starts.front() * typical_size(info.scale, model, experiment, component.joint, model.values());
  Problem problem(model, experiment, current.space, coarse.simulator, current.weights);
  std::vector<double> values = model.values();
  const std::vector<double> plain = current.space.expand(current.fit.point);
  std::copy(plain.begin(), plain.end(), values.begin());
  values[static_cast<std::size_t>(axis.parameter)] = size;
  const std::vector<std::vector<double>> one{values};
  const Eigen::VectorXd column = (coarse.residuals_of(problem, one, train).front() - current.fit.residual) / size;
  const Eigen::Index base = current.fit.jacobian.cols(), count = static_cast<Eigen::Index>(files.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(column.size(), base + count);
  J.leftCols(base) = current.fit.jacobian;
  for (const ResidualBlock& block : problem.layout(train)) {
    const std::string& file = experiment.segments[static_cast<std::size_t>(block.segment)].file;
    const auto place = std::find(files.begin(), files.end(), file) - files.begin();
    J.col(base + place).segment(block.first, block.count) = column.segment(block.first, block.count);
  }
  Eigen::MatrixXd normal = J.transpose() * J;
  normal.diagonal() *= 1.0 + kEstimateDamping;
  const Eigen::VectorXd sizes = normal.ldlt().solve(-(J.transpose() * current.fit.residual).eval()).tail(count);
  if (!sizes.allFinite()) return {};
  const double low = sizes.minCoeff(), high = sizes.maxCoeff();
  std::vector<std::string> on;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (sizes(k) > 0.5 * (low + high)) on.push_back(files[static_cast<std::size_t>(k)]);
  }
  return on.size() < files.size() ? on : std::vector<std::string>{};
}

std::vector<std::string> recordings_with_effect(const PlantModel& model, const Component& component,
                                                std::span<const double> values, const Experiment& experiment,
                                                const SimulatorOptions& options, const std::vector<double>& weights,
                                                const std::vector<Role>& roles) {
  constexpr double kLook = 1.0;  // s of a recording's start that decide
  std::vector<int> first;        // the first segment of every file
  std::vector<std::string> files;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s) {
    const Segment& segment = experiment.segments[s];
    if (std::find(roles.begin(), roles.end(), segment.role) == roles.end()) continue;
    if (std::find(files.begin(), files.end(), segment.file) != files.end()) continue;
    files.push_back(segment.file);
    first.push_back(static_cast<int>(s));
  }
  std::vector<std::vector<double>> both(2, std::vector<double>(values.begin(), values.end()));
  for (int k = 0; k < component.count; ++k) {
    const auto i = static_cast<std::size_t>(component.first + k);
    both[1][i] = model.parameters()[i].neutral;
  }
  std::vector<std::array<double, 2>> energy(experiment.segments.size(), {0.0, 0.0});
  const auto energy_of = [&](int which, int s) -> double& {
    return energy[static_cast<std::size_t>(s)][static_cast<std::size_t>(which)];
  };
  const auto sum = [&](int which, int s, const auto& predicted) {
    const Segment& segment = experiment.segments[static_cast<std::size_t>(s)];
    for (std::size_t c = 0; c < predicted.size() && c < segment.measured.size(); ++c) {
      for (std::size_t k = 0; k < segment.count && segment.time(k) - segment.time(0) <= kLook; ++k) {
        const double e = (predicted[c][k] - segment.measured[c][k]) / weights[c];
        if (std::isfinite(e)) energy_of(which, s) += e * e;
      }
    }
  };
  make_simulator(model, experiment, options)->run(both, first, sum, [&](int which, int s) {
    return std::as_writable_bytes(std::span(&energy_of(which, s), 1));
  });
  std::vector<std::string> on;
  for (std::size_t k = 0; k < files.size(); ++k) {
    const auto& [with, without] = energy[static_cast<std::size_t>(first[k])];
    if (with < without) on.push_back(files[k]);
  }
  return on;
}

}  // namespace lacuna
