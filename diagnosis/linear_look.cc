#include "diagnosis/linear_look.h"

#include <algorithm>

#include "physics/effects/table.h"

namespace lacuna {
namespace {

bool is_simulated(const Experiment& experiment) {
  return std::all_of(experiment.channels.begin(), experiment.channels.end(), [](const Channel& c) {
    return c.kind == ChannelKind::position || c.kind == ChannelKind::velocity;
  });
}

constexpr double kPush = 1e-3;  ///< of a joint's typical effort, by which the prediction's sensitivity is taken

const Hooks<double>& hooks_of_type(int type) { return Effects::hooks<double>()[type]; }

/// Whether the link and what drives it are two.
bool has_sides(const PlantModel& model) {
  return std::any_of(model.effects().begin(), model.effects().end(), [](const Component& c) {
    const Hooks<double>& hooks = hooks_of_type(c.type);
    return hooks.lead != nullptr || hooks.base != nullptr;
  });
}

Eigen::MatrixXd matrix_of(const std::vector<std::vector<double>>& efforts) {
  Eigen::MatrixXd out(efforts.size(), efforts.front().size());
  for (std::size_t j = 0; j < efforts.size(); ++j)
    out.row(j) = Eigen::Map<const Eigen::RowVectorXd>(efforts[j].data(), efforts[j].size());
  return out;
}

}  // namespace

LinearLook::LinearLook(const CurrentModel& current, const FitContext& context, std::vector<int> segments)
    : current_(current),
      experiment_(context.experiment),
      simulator_(context.simulator),
      segments_(std::move(segments)),
      is_measured_(std::holds_alternative<InverseDynamics>(experiment_.prediction)) {
  if (is_measured_)
    probe_efforts();
  else if (is_simulated(experiment_) && !has_sides(current.model))
    linearise();
}

void LinearLook::linearise() {
  const std::vector<std::vector<double>> values{current_.space.expand(current_.fit.point)};
  std::vector<double> sizes;
  for (int j = 0; j < current_.model.dof(); ++j)
    sizes.push_back(typical_size(Scale::effort, current_.model, experiment_, j, values.front()));
  const auto plain = make_simulator(current_.model, experiment_, simulator_);
  motions_ = plain->linearise(values.front(), segments_, sizes);
  if (!std::all_of(motions_.begin(), motions_.end(), [](const LinearMotion& m) { return m.is_finite(); })) return;
  needs_.resize(experiment_.segments.size());
  plain->excess(values, segments_, motions_, [&](int, int s, const auto& efforts) { needs_[s] = matrix_of(efforts); });
  problem_.emplace(current_.model, experiment_, current_.space, simulator_, current_.weights);
}

void LinearLook::probe_efforts() {
  constexpr const char* kProbe = "torque_offset";
  std::vector<EffectSpec> absent;
  for (const std::string& joint : experiment_.joint_names)
    if (current_.model.find_effect_at(kProbe, joint) < 0) absent.push_back({kProbe, joint, {}, {}, kProbe});
  const PlantModel model = current_.model.with_effects(absent);
  std::vector<double> present = model.values();
  const std::vector<double> fitted = current_.space.expand(current_.fit.point);
  std::copy(fitted.begin(), fitted.end(), present.begin());
  std::vector<std::vector<double>> pushed{present, present};
  double size = 0.0;
  for (int j = 0; j < model.dof(); ++j)
    size = std::max(size, typical_size(Scale::effort, model, experiment_, j, present));
  const double push = kPush * (size > 0.0 ? size : 1.0);
  for (const std::string& joint : experiment_.joint_names) pushed[1][model.find(joint + ".torque_offset.tau0")] += push;
  std::vector<std::vector<std::vector<double>>> predicted(2);
  make_simulator(model, experiment_, simulator_)
      ->run(pushed, std::span(&segments_.front(), 1),
            [&](int individual, int, const auto& channels) { predicted[individual] = channels; });
  for (std::size_t c = 0; c < experiment_.channels.size(); ++c) {
    double sum = 0.0;
    for (std::size_t k = 0; k < predicted[0][c].size(); ++k) sum += predicted[1][c][k] - predicted[0][c][k];
    per_effort_.push_back(sum / (push * static_cast<double>(predicted[0][c].size())));
  }
  problem_.emplace(current_.model, experiment_, current_.space, simulator_, current_.weights);
}

const MeasuredMotion& LinearLook::motion(std::size_t at) const {
  return is_measured_ ? *experiment_.segments[segments_[at]].motion : *motions_[at].between;
}

bool LinearLook::applies(const EffectInfo& effect) const {
  const Hooks<double>& hooks = hooks_of_type(find_effect(effect.name));
  return problem_ && !is_measured_ && hooks.sense == nullptr && hooks.measure == nullptr && hooks.delay == nullptr &&
         hooks.lead == nullptr && hooks.base == nullptr;
}

std::vector<Eigen::VectorXd> LinearLook::changes(const PlantModel& model,
                                                 std::span<const std::vector<double>> values) const {
  // [individual][segment]: changes of positions and speeds.
  std::vector<std::vector<Eigen::MatrixXd>> responses(values.size(),
                                                      std::vector<Eigen::MatrixXd>(experiment_.segments.size()));
  std::vector<std::size_t> at(experiment_.segments.size(), 0);
  for (std::size_t k = 0; k < segments_.size(); ++k) at[segments_[k]] = k;
  make_simulator(model, experiment_, simulator_)
      ->excess(values, segments_, motions_, [&](int individual, int segment, const auto& efforts) {
        responses[individual][segment] = motions_[at[segment]].response(matrix_of(efforts) - needs_[segment]);
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
  if (is_measured_) return changes_of_efforts(at, joint, efforts);
  constexpr Eigen::Index kTogether = 32;  // columns: as many as keep the responses small
  const Eigen::Index dof = current_.model.dof();
  Eigen::MatrixXd out;
  for (Eigen::Index first = 0; first < efforts.rows(); first += kTogether) {
    const Eigen::Index count = std::min(kTogether, efforts.rows() - first);
    const std::vector<Eigen::MatrixXd> responses = motions_[at].responses_at(joint, efforts.middleRows(first, count));
    for (Eigen::Index k = 0; k < count; ++k)
      put(at, out, first + k, efforts.rows(), [&](std::size_t c) -> Eigen::VectorXd {
        const Channel& channel = experiment_.channels[c];
        const Eigen::Index row = channel.joint + (channel.kind == ChannelKind::velocity ? dof : 0);
        return responses[k].row(row);
      });
  }
  return out;
}

Eigen::MatrixXd LinearLook::changes_of_efforts(std::size_t at, int joint, const Eigen::MatrixXd& efforts) const {
  const Segment& segment = experiment_.segments[segments_[at]];
  const ZeroPhaseLowPass filter(std::get<InverseDynamics>(experiment_.prediction).cutoff_hz, segment.motion->rate);
  const auto n = static_cast<Eigen::Index>(segment.compared.size());
  Eigen::MatrixXd out;
  for (Eigen::Index k = 0; k < efforts.rows(); ++k) {
    std::vector<double> signal(efforts.row(k).begin(), efforts.row(k).end());
    filter.apply(signal);
    Eigen::VectorXd compared(n);
    for (Eigen::Index i = 0; i < n; ++i) compared(i) = signal[segment.compared[i]];
    put(at, out, k, efforts.rows(), [&](std::size_t c) -> Eigen::VectorXd {
      if (experiment_.channels[c].joint != joint) return Eigen::VectorXd::Zero(n);
      return per_effort_[c] * compared;
    });
  }
  return out;
}

Eigen::MatrixXd LinearLook::changes_read_in(std::size_t at, int joint, const Eigen::MatrixXd& slips) const {
  Eigen::MatrixXd out;
  for (Eigen::Index k = 0; k < slips.rows(); ++k)
    put(at, out, k, slips.rows(), [&](std::size_t c) -> Eigen::VectorXd {
      const Channel& channel = experiment_.channels[c];
      if (channel.kind == ChannelKind::position && channel.joint == joint) return slips.row(k);
      return Eigen::VectorXd::Zero(slips.cols());
    });
  return out;
}

void LinearLook::put(std::size_t at, Eigen::MatrixXd& out, Eigen::Index column, Eigen::Index columns,
                     const std::function<Eigen::VectorXd(std::size_t channel)>& change) const {
  const Eigen::VectorXd whitened = problem_->residual_change(
      std::span(&segments_[at], 1), [&](std::size_t, std::size_t c) -> Eigen::VectorXd { return change(c); });
  if (out.size() == 0) out.resize(whitened.size(), columns);
  out.col(column) = whitened;
}

}  // namespace lacuna
