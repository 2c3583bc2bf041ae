#include "diagnosis/partial.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.h"

namespace lacuna {
namespace {

constexpr double kEstimateDamping = 1e-6;  // of the linear estimate, relative to the normal matrix' diagonal
constexpr double kLook = 1.0;              // s of a recording's start that decide

std::vector<std::string> files_of(const Experiment& experiment, Role role) {
  std::vector<std::string> out;
  for (const int s : experiment.with_role(role)) {
    const std::string& file = experiment.segments[s].file;
    if (std::find(out.begin(), out.end(), file) == out.end()) out.push_back(file);
  }
  return out;
}

/// Segments of `roles` that say whether an effect is on: of efforts all, else the first of every file.
std::vector<int> deciding_segments(const Experiment& experiment, const std::vector<Role>& roles, bool efforts) {
  std::vector<int> out;
  std::vector<std::string> files;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s) {
    const Segment& segment = experiment.segments[s];
    if (std::find(roles.begin(), roles.end(), segment.role) == roles.end()) continue;
    const bool seen = std::find(files.begin(), files.end(), segment.file) != files.end();
    if (seen && !efforts) continue;
    files.push_back(segment.file);
    out.push_back(static_cast<int>(s));
  }
  return out;
}

/// Residual rows of a channel in the first kLook of a segment: missing samples have none.
Eigen::Index rows_at_start(const Segment& segment, std::size_t channel) {
  const std::vector<double>& measured = segment.measured[channel];
  Eigen::Index rows = 0;
  for (std::size_t k = 0; k < segment.count && segment.time(k) - segment.time(0) <= kLook; ++k)
    rows += std::isfinite(measured[k]);
  return rows;
}

}  // namespace

std::vector<std::string> likely_recordings(const CurrentModel& current, const CoarseLook& coarse,
                                           const EffectSpec& spec) {
  const Experiment& experiment = coarse.context.experiment;
  const std::vector<int> train = experiment.with_role(Role::train);
  const std::vector<std::string> files = files_of(experiment, Role::train);
  if (files.size() < 2) return {};
  const PlantModel model = current.model.with_effects({spec});
  const Component& component = model.effects().back();
  const Axis axis = effect_axes(model, experiment, component, spec).front();
  const ParameterInfo& info = *model.parameters()[axis.parameter].info;
  const double size =
      info.starts.front() * typical_size(info.scale, model, experiment, component.joint, model.values());
  Problem problem(model, experiment, current.space, coarse.context.simulator, current.weights);
  std::vector<double> values = model.values();
  const std::vector<double> plain = current.space.expand(current.fit.point);
  std::copy(plain.begin(), plain.end(), values.begin());
  values[axis.parameter] = size;
  const std::vector<std::vector<double>> one{values};
  const Eigen::VectorXd column = (coarse.residuals_of(problem, one, train).front() - current.fit.residual) / size;
  const Eigen::Index base = current.fit.jacobian.cols(), count = static_cast<Eigen::Index>(files.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(column.size(), base + count);
  J.leftCols(base) = current.fit.jacobian;
  for (const ResidualBlock& block : problem.layout(train)) {
    const std::string& file = experiment.segments[block.segment].file;
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
    if (sizes(k) > 0.5 * (low + high)) on.push_back(files[k]);
  }
  return on.size() < files.size() ? on : std::vector<std::string>{};
}

std::vector<std::string> recordings_with_effect(const CurrentModel& with, const FitContext& context,
                                                const std::vector<Role>& roles) {
  const bool efforts = std::holds_alternative<InverseDynamics>(context.experiment.prediction);
  const std::vector<int> segments = deciding_segments(context.experiment, roles, efforts);
  if (segments.empty()) return {};
  std::vector<std::vector<double>> both(2, with.space.expand(with.fit.point));
  const Component& component = with.model.effects().back();
  for (int k = 0; k < component.count; ++k) {
    const std::size_t i = component.first + k;
    both[1][i] = with.model.parameters()[i].neutral;
  }
  Problem problem = problem_of(with, context);
  const std::vector<Eigen::VectorXd> residuals = problem.residuals_of(both, segments);
  std::vector<std::pair<std::string, double>> gained;  // energy that it removes, by file
  for (const ResidualBlock& block : problem.layout(segments)) {
    const Segment& segment = context.experiment.segments[block.segment];
    const Eigen::Index rows = efforts ? block.count : rows_at_start(segment, static_cast<std::size_t>(block.channel));
    const auto energy = [&](const Eigen::VectorXd& r) { return r.segment(block.first, rows).squaredNorm(); };
    if (gained.empty() || gained.back().first != segment.file) gained.emplace_back(segment.file, 0.0);
    gained.back().second += energy(residuals[1]) - energy(residuals[0]);
  }
  std::vector<std::string> on;
  for (const auto& [file, energy] : gained) {
    if (energy > 0.0 && std::find(on.begin(), on.end(), file) == on.end()) on.push_back(file);
  }
  return on;
}

}  // namespace lacuna
