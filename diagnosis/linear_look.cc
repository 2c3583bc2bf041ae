#include "diagnosis/linear_look.h"

#include <algorithm>

#include "physics/effects/table.h"

namespace lacuna {
namespace {

bool is_simulated(const Experiment& experiment) {
  return !std::holds_alternative<InverseDynamics>(experiment.prediction) &&
         std::all_of(experiment.channels.begin(), experiment.channels.end(), [](const Channel& c) {
           return c.kind == ChannelKind::position || c.kind == ChannelKind::velocity;
         });
}

const Hooks<double>& hooks_of_type(int type) { return Effects::hooks<double>()[static_cast<std::size_t>(type)]; }

/// Whether the link and what drives it are two.
bool has_sides(const PlantModel& model) {
  return std::any_of(model.effects().begin(), model.effects().end(), [](const Component& c) {
    const Hooks<double>& hooks = hooks_of_type(c.type);
    return hooks.lead != nullptr || hooks.base != nullptr;
  });
}

Eigen::MatrixXd matrix_of(const std::vector<std::vector<double>>& efforts) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(efforts.size()), static_cast<Eigen::Index>(efforts.front().size()));
  for (std::size_t j = 0; j < efforts.size(); ++j)
    out.row(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Eigen::RowVectorXd>(efforts[j].data(), static_cast<Eigen::Index>(efforts[j].size()));
  return out;
}

}  // namespace

LinearLook::LinearLook(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
                       std::vector<int> segments)
    : current_(current), experiment_(experiment), simulator_(simulator), segments_(std::move(segments)) {
  if (!is_simulated(experiment) || has_sides(current.model)) return;
  const std::vector<std::vector<double>> values{current.space.expand(current.fit.point)};
  std::vector<double> sizes;
  for (int j = 0; j < current.model.dof(); ++j)
    sizes.push_back(typical_size(Scale::effort, current.model, experiment, j, values.front()));
  const auto plain = make_simulator(current.model, experiment, simulator);
  motions_ = plain->linearise(values.front(), segments_, sizes);
  if (!std::all_of(motions_.begin(), motions_.end(), [](const LinearMotion& m) { return m.is_finite(); })) return;
  needs_.resize(experiment.segments.size());
  plain->excess(values, segments_, motions_,
                [&](int, int s, const auto& efforts) { needs_[static_cast<std::size_t>(s)] = matrix_of(efforts); });
  problem_.emplace(current.model, experiment, current.space, simulator, current.weights);
}

bool LinearLook::applies(const EffectInfo& effect) const {
  const Hooks<double>& hooks = hooks_of_type(find_effect(effect.name));
  return problem_ && hooks.sense == nullptr && hooks.measure == nullptr && hooks.delay == nullptr &&
         hooks.lead == nullptr && hooks.base == nullptr;
}

std::vector<Eigen::VectorXd> LinearLook::changes(const PlantModel& model,
                                                 std::span<const std::vector<double>> values) const {
  // [individual][segment]: changes of positions and speeds.
  std::vector<std::vector<Eigen::MatrixXd>> responses(values.size(),
                                                      std::vector<Eigen::MatrixXd>(experiment_.segments.size()));
  std::vector<std::size_t> at(experiment_.segments.size(), 0);
  for (std::size_t k = 0; k < segments_.size(); ++k) at[static_cast<std::size_t>(segments_[k])] = k;
  make_simulator(model, experiment_, simulator_)
      ->excess(values, segments_, motions_, [&](int individual, int segment, const auto& efforts) {
        const auto s = static_cast<std::size_t>(segment);
        responses[static_cast<std::size_t>(individual)][s] = motions_[at[s]].response(matrix_of(efforts) - needs_[s]);
      });
  std::vector<Eigen::VectorXd> out;
  for (const std::vector<Eigen::MatrixXd>& response : responses) out.push_back(residual_of(response));
  return out;
}

Eigen::VectorXd LinearLook::residual_of(const std::vector<Eigen::MatrixXd>& responses) const {
  const Eigen::Index dof = current_.model.dof();
  return problem_->residual_change(segments_, [&](std::size_t segment, std::size_t c) -> Eigen::VectorXd {
    const Channel& channel = experiment_.channels[c];
    return responses[segment].row(channel.joint + (channel.kind == ChannelKind::velocity ? dof : 0));
  });
}

Eigen::MatrixXd LinearLook::changes_at(int joint, const std::vector<Eigen::MatrixXd>& efforts) const {
  return stacked([&](std::size_t at) { return changes_in(at, joint, efforts[at]); });
}

Eigen::MatrixXd LinearLook::changes_read(int joint, const std::vector<Eigen::MatrixXd>& slips) const {
  return stacked([&](std::size_t at) { return changes_read_in(at, joint, slips[at]); });
}

Eigen::MatrixXd LinearLook::stacked(const std::function<Eigen::MatrixXd(std::size_t at)>& part) const {
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index rows = 0;
  for (std::size_t at = 0; at < segments_.size(); ++at) {
    parts.push_back(part(at));
    rows += parts.back().rows();
  }
  Eigen::MatrixXd out(rows, parts.front().cols());
  rows = 0;
  for (const Eigen::MatrixXd& one : parts) {
    out.middleRows(rows, one.rows()) = one;
    rows += one.rows();
  }
  return out;
}

Eigen::MatrixXd LinearLook::changes_in(std::size_t at, int joint, const Eigen::MatrixXd& efforts) const {
  constexpr Eigen::Index kTogether = 32;  // columns: as many as keep the responses small
  const Eigen::Index dof = current_.model.dof();
  Eigen::MatrixXd out;
  for (Eigen::Index first = 0; first < efforts.rows(); first += kTogether) {
    const Eigen::Index count = std::min(kTogether, efforts.rows() - first);
    const std::vector<Eigen::MatrixXd> responses = motions_[at].responses_at(joint, efforts.middleRows(first, count));
    for (Eigen::Index k = 0; k < count; ++k)
      put(at, out, first + k, efforts.rows(), [&](const Channel& channel) -> Eigen::VectorXd {
        const Eigen::Index row = channel.joint + (channel.kind == ChannelKind::velocity ? dof : 0);
        return responses[static_cast<std::size_t>(k)].row(row);
      });
  }
  return out;
}

Eigen::MatrixXd LinearLook::changes_read_in(std::size_t at, int joint, const Eigen::MatrixXd& slips) const {
  Eigen::MatrixXd out;
  for (Eigen::Index k = 0; k < slips.rows(); ++k)
    put(at, out, k, slips.rows(), [&](const Channel& channel) -> Eigen::VectorXd {
      if (channel.kind == ChannelKind::position && channel.joint == joint) return slips.row(k);
      return Eigen::VectorXd::Zero(slips.cols());
    });
  return out;
}

void LinearLook::put(std::size_t at, Eigen::MatrixXd& out, Eigen::Index column, Eigen::Index columns,
                     const std::function<Eigen::VectorXd(const Channel&)>& change) const {
  const Eigen::VectorXd whitened = problem_->residual_change(
      std::span(&segments_[at], 1),
      [&](std::size_t, std::size_t c) -> Eigen::VectorXd { return change(experiment_.channels[c]); });
  if (out.size() == 0) out.resize(whitened.size(), columns);
  out.col(column) = whitened;
}

}  // namespace lacuna
