#include "ga/problem.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <type_traits>

#include "ga/random.h"
#include "physics/reach.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

/// Step of the forward difference, as a share of the coordinate's size: far above rounding (1e-16 / 1e-6), far below
/// the curvature of any response here.
constexpr double kDifference = 1e-6;

double difference_step(const Axis& axis, double x) {
  // A logarithm's size is one: its zero is as good as any other place.
  const double size = axis.coordinate == Coordinate::logarithm
                          ? 1.0
                          : std::max(std::fabs(x), 1e-3 * std::min(axis.upper - axis.lower, 1e6));
  const double step = kDifference * std::max(size, 1e-12);
  return x + step <= axis.upper ? step : -step;
}

/// Columns of a Jacobian too few to be worth looking for a longer step.
constexpr std::size_t kFewColumns = 8;
/// Error of any channel's sensitivity, rms over its own, that a longer step may make. Least squares then gains a factor
/// of 50 a step still, and a standard error is right to 2 %.
constexpr double kSensitivityError = 0.02;

/// `step` doubled as often as it stays within a sampling period: integration steps end at samples.
double coarsest(double step, double sample_period) {
  while (2.0 * step <= sample_period) step *= 2.0;
  return step;
}

/// Whether two changes of the residual agree in every channel.
bool agree(const Eigen::VectorXd& change, const Eigen::VectorXd& exact, std::span<const ResidualBlock> blocks) {
  std::map<int, std::pair<double, double>> channels;  // energies of the error and of the change
  for (const ResidualBlock& block : blocks) {
    auto& [error, size] = channels[block.channel];
    error += (change - exact).segment(block.first, block.count).squaredNorm();
    size += exact.segment(block.first, block.count).squaredNorm();
  }
  return std::ranges::all_of(channels, [](const auto& channel) {
    const auto& [error, size] = channel.second;
    return error <= kSensitivityError * kSensitivityError * size;  // not so for NaN
  });
}

/// Which coordinates one simulation may move together, and which channels each of them changes then.
struct Groups {
  std::vector<int> region;                         ///< [joint]: joints of different regions keep apart
  std::vector<std::vector<std::size_t>> together;  ///< [simulation]: axes, each of another region
};

/// Branches of the tree, which cannot move each other; where the motion is measured, each joint's own affairs.
Groups moved_together(const PlantModel& model, const SearchSpace& space, const Prediction& prediction) {
  const std::vector<bool> stays = stays_at_its_joint(model, prediction);
  const bool by_joint = std::ranges::find(stays, true) != stays.end();
  Groups out{branches(model), {}};
  if (by_joint) std::iota(out.region.begin(), out.region.end(), 0);
  std::vector<std::vector<std::size_t>> alone;
  std::map<int, std::size_t> next;  // [region]: the first simulation that moves nothing in it
  for (std::size_t a = 0; a < space.size(); ++a) {
    const std::size_t parameter = space.axes()[a].parameter;
    const int joint = model.parameters()[parameter].joint;
    if (joint < 0 || (by_joint ? !stays[parameter] : space.dependent() >= 0)) {
      alone.push_back({a});
      continue;
    }
    std::size_t& k = next[out.region[joint]];
    if (k >= out.together.size()) out.together.resize(k + 1);
    out.together[k++].push_back(a);
  }
  out.together.insert(out.together.end(), alone.begin(), alone.end());
  return out;
}

/// Where the rows of one segment stand in a stacked residual, and the blocks that they are made of.
struct SegmentRows {
  std::size_t segment;
  std::span<const ResidualBlock> blocks;
  Eigen::Index first, count;
};
std::vector<SegmentRows> rows_of_segments(std::span<const ResidualBlock> blocks) {
  std::vector<SegmentRows> out;
  for (std::size_t first = 0, last = 0; first < blocks.size(); first = last) {
    Eigen::Index count = 0;
    for (; last < blocks.size() && blocks[last].segment == blocks[first].segment; ++last) count += blocks[last].count;
    out.push_back({static_cast<std::size_t>(blocks[first].segment), blocks.subspan(first, last - first),
                   blocks[first].first, count});
  }
  return out;
}

}  // namespace

bool is_leading(const Experiment& experiment, std::size_t c) {
  const ChannelKind kind = experiment.channels[c].kind;
  const bool inverse = std::holds_alternative<InverseDynamics>(experiment.prediction);
  return inverse ? kind == ChannelKind::effort || kind == ChannelKind::command : kind == ChannelKind::position;
}

/// rms about the mean of what a channel measured on the train recordings.
double spread_of(const Experiment& experiment, std::size_t channel) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const int s : experiment.with_role(Role::train)) {
    for (const double x : experiment.segments[s].measured[channel])
      if (std::isfinite(x)) n += 1.0, sum += x, squares += x * x;
  }
  return n > 0.0 ? std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n))) : 0.0;
}

std::vector<double> first_weights(const PlantModel&, const Experiment& experiment) {
  std::vector<double> out;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const std::size_t j = channel.joint;
    const bool pressure = channel.kind == ChannelKind::pressure_a || channel.kind == ChannelKind::pressure_b;
    double weight = channel.noise;
    if (!(weight > 0.0)) {
      weight = 1e-2 * (channel.kind == ChannelKind::command    ? experiment.command_rms[j]
                       : channel.kind == ChannelKind::effort   ? experiment.effort_rms[j]
                       : channel.kind == ChannelKind::velocity ? experiment.speed_rms[j]
                       : pressure                              ? spread_of(experiment, c)
                                                               : experiment.position_rms[j]);
    }
    out.push_back(weight > 0.0 ? weight : 1.0);
  }
  return out;
}

Problem::Problem(const PlantModel& model, const Experiment& experiment, const SearchSpace& space,
                 const SimulatorOptions& options, std::vector<double> weights)
    : model_(model),
      experiment_(experiment),
      space_(space),
      options_(options),
      weights_(std::move(weights)),
      simulator_(make_simulator(model, experiment, options)) {
  whiten_starts();
}

void Problem::whiten_starts() {
  for (std::size_t s = 0; s < experiment_.segments.size(); ++s) {
    const StartEffects* effects = experiment_.segments[s].start_effects.get();
    if (effects == nullptr) continue;
    starts_.resize(experiment_.segments.size());
    const int one[] = {static_cast<int>(s)};
    const std::vector<ResidualBlock> blocks = layout(one);
    Eigen::VectorXd rows(blocks.back().first + blocks.back().count);
    for (const ResidualBlock& block : blocks)
      rows.segment(block.first, block.count).setConstant(weights_[block.channel]);
    starts_[s] = StartWhitening(effects->columns, std::move(rows));
  }
}

std::vector<ResidualBlock> Problem::layout(std::span<const int> segments) const {
  std::vector<ResidualBlock> out;
  Eigen::Index row = 0;
  for (const int s : segments) {
    const Segment& segment = experiment_.segments[s];
    for (std::size_t c = 0; c < weights_.size(); ++c) {
      const auto& column = segment.measured[c];
      const Eigen::Index count = std::count_if(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
      out.push_back({s, static_cast<int>(c), row, count});
      row += count;
    }
  }
  return out;
}

std::vector<Eigen::VectorXd> Problem::residuals_of(std::span<const std::vector<double>> values,
                                                   std::span<const int> segments) {
  std::vector<Eigen::VectorXd> out = plain_residuals_of(values, segments);
  if (starts_.empty()) return out;
  const std::vector<ResidualBlock> blocks = layout(segments);
  for (const SegmentRows& rows : rows_of_segments(blocks))
    for (Eigen::VectorXd& r : out) starts_[rows.segment].apply(r.segment(rows.first, rows.count));
  return out;
}

std::vector<Eigen::VectorXd> Problem::plain_residuals_of(std::span<const std::vector<double>> values,
                                                         std::span<const int> segments) {
  const std::vector<ResidualBlock> blocks = layout(segments);
  const Eigen::Index rows = blocks.empty() ? 0 : blocks.back().first + blocks.back().count;
  std::vector<Eigen::VectorXd> out(values.size(), Eigen::VectorXd(rows));
  const auto write = [&](int individual, int s, const auto& predicted) {
    const Segment& segment = experiment_.segments[s];
    Eigen::VectorXd& r = out[individual];
    for (const ResidualBlock& block : blocks) {
      if (block.segment != s) continue;
      const std::size_t c = block.channel;
      Eigen::Index row = block.first;
      for (std::size_t k = 0; k < predicted[c].size(); ++k) {
        const double measured = segment.measured[c][k];
        if (std::isfinite(measured)) r(row++) = (predicted[c][k] - measured) / weights_[c];
      }
    }
  };
  // The rows of one segment stand together.
  const auto rows_of = [&](int individual, int s) {
    const auto of = [s](const ResidualBlock& block) { return block.segment == s; };
    const auto first = std::find_if(blocks.begin(), blocks.end(), of);
    const auto last = std::find_if_not(first, blocks.end(), of);
    const Eigen::Index count = std::prev(last)->first + std::prev(last)->count - first->first;
    return std::as_writable_bytes(std::span(out[individual].data() + first->first, static_cast<std::size_t>(count)));
  };
  simulator_->run(values, segments, write, rows_of);
  return out;
}

std::vector<Eigen::VectorXd> Problem::residuals(std::span<const std::vector<double>> points,
                                                std::span<const int> segments) {
  std::vector<std::vector<double>> values;
  for (const std::vector<double>& point : points) values.push_back(space_.expand(point));
  return residuals_of(values, segments);
}

Eigen::VectorXd Problem::residual(const std::vector<double>& point, std::span<const int> segments) {
  const std::vector<std::vector<double>> one{point};
  return residuals(one, segments).front();
}

Eigen::MatrixXd Problem::jacobian(const std::vector<double>& point, const Eigen::VectorXd& at,
                                  std::span<const int> segments) {
  const double step = sensitivity_step(point, at, segments);
  if (!(step > options_.max_step)) return differences(point, at, segments);
  Problem coarse = at_step(step);
  return coarse.differences(point, coarse.residual(point, segments), segments);
}

Problem Problem::at_step(double step) const {
  SimulatorOptions options = options_;
  options.max_step = step;
  return {model_, experiment_, space_, options, weights_};
}

double Problem::sensitivity_step(const std::vector<double>& point, const Eigen::VectorXd& at,
                                 std::span<const int> segments) {
  const bool integrated = !std::holds_alternative<InverseDynamics>(experiment_.prediction);
  if (!integrated || point.size() < kFewColumns || !at.allFinite()) return options_.max_step;
  std::vector<double> moved = point;
  RandomStream sign(0, 0, 0);
  for (std::size_t a = 0; a < point.size(); ++a) {
    const Axis& axis = space_.axes()[a];
    const double by = (sign.chance(0.5) ? 1.0 : -1.0) * difference_step(axis, point[a]);
    moved[a] = std::clamp(point[a] + by, axis.lower, axis.upper);
  }
  Eigen::VectorXd exact;
  for (double step = coarsest(options_.max_step, experiment_.sample_period); step > options_.max_step; step *= 0.5) {
    if (exact.size() == 0) exact = residual(moved, segments) - at;
    const std::vector<std::vector<double>> both{point, moved};
    const std::vector<Eigen::VectorXd> there = at_step(step).residuals(both, segments);
    if (agree(there[1] - there[0], exact, layout(segments))) return step;
  }
  return options_.max_step;
}

Eigen::MatrixXd Problem::differences(const std::vector<double>& point, const Eigen::VectorXd& at,
                                     std::span<const int> segments) {
  const auto [region, together] = moved_together(model_, space_, experiment_.prediction);
  std::vector<std::vector<double>> points(together.size(), point);
  for (std::size_t k = 0; k < together.size(); ++k)
    for (const std::size_t a : together[k]) points[k][a] += difference_step(space_.axes()[a], point[a]);
  const std::vector<Eigen::VectorXd> moved = residuals(points, segments);
  const std::vector<ResidualBlock> blocks = layout(segments);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at.size(), space_.size());
  for (std::size_t k = 0; k < together.size(); ++k) {
    for (const std::size_t a : together[k]) {
      const int joint = model_.parameters()[space_.axes()[a].parameter].joint;
      auto column = J.col(a);
      for (const ResidualBlock& block : blocks) {
        const std::size_t of = experiment_.channels[block.channel].joint;
        if (together[k].size() > 1 && region[of] != region[joint]) continue;
        column.segment(block.first, block.count) =
            (moved[k] - at).segment(block.first, block.count) / (points[k][a] - point[a]);
      }
    }
  }
  return J;
}

Eigen::VectorXd Problem::residual_change(std::span<const int> segments,
                                         const std::function<Eigen::VectorXd(std::size_t, std::size_t)>& change) const {
  const std::vector<ResidualBlock> blocks = layout(segments);
  Eigen::VectorXd out(blocks.empty() ? 0 : blocks.back().first + blocks.back().count);
  for (const ResidualBlock& block : blocks) {
    const std::size_t s = static_cast<std::size_t>(block.segment), c = static_cast<std::size_t>(block.channel);
    const std::vector<double>& measured = experiment_.segments[s].measured[c];
    const Eigen::VectorXd changed = change(s, c);
    Eigen::Index row = block.first;
    for (std::size_t k = 0; k < measured.size(); ++k)
      if (std::isfinite(measured[k])) out(row++) = changed(k) / weights_[c];
  }
  if (starts_.empty()) return out;
  for (const SegmentRows& rows : rows_of_segments(blocks))
    starts_[rows.segment].apply(out.segment(rows.first, rows.count));
  return out;
}

Eigen::MatrixXd Problem::reweighed(Eigen::MatrixXd rows, const Problem& before, std::span<const int> segments) const {
  const std::vector<ResidualBlock> blocks = layout(segments);
  for (const SegmentRows& segment : rows_of_segments(blocks)) {
    for (Eigen::Index column = 0; column < rows.cols(); ++column) {
      auto part = rows.col(column).segment(segment.first, segment.count);
      if (!before.starts_.empty()) before.starts_[segment.segment].undo(part);
      for (const ResidualBlock& b : segment.blocks) {
        const std::size_t c = b.channel;
        part.segment(b.first - segment.first, b.count) *= before.weights_[c] / weights_[c];
      }
      if (!starts_.empty()) starts_[segment.segment].apply(part);
    }
  }
  return rows;
}

void Problem::costs(std::span<const std::vector<double>> points, std::span<double> out, std::span<const int> segments,
                    Fitness fitness) {
  std::vector<std::vector<double>> values;
  for (const std::vector<double>& point : points) values.push_back(space_.expand(point));
  // One accumulator for each individual and segment, merged in a fixed order: the same bits for any number of threads.
  std::vector<std::vector<NormAccumulator>> sums(points.size(), std::vector<NormAccumulator>(segments.size()));
  std::vector<std::size_t> place(experiment_.segments.size(), 0);
  for (std::size_t k = 0; k < segments.size(); ++k) place[segments[k]] = k;
  const auto sum_of = [&](int individual, int s) -> NormAccumulator& { return sums[individual][place[s]]; };
  const auto accumulate = [&](int individual, int s, const auto& predicted) {
    const Segment& segment = experiment_.segments[s];
    NormAccumulator& sum = sum_of(individual, s);
    for (std::size_t c = 0; c < predicted.size(); ++c) {
      for (std::size_t k = 0; k < predicted[c].size(); ++k) {
        const double measured = segment.measured[c][k];
        sum.add((predicted[c][k] - measured) / weights_[c], measured / weights_[c]);
      }
    }
  };
  static_assert(std::is_trivially_copyable_v<NormAccumulator>, "ranks hand each other its bytes");
  simulator_->run(values, segments, accumulate,
                  [&](int i, int s) { return std::as_writable_bytes(std::span(&sum_of(i, s), 1)); });
  for (std::size_t i = 0; i < points.size(); ++i) {
    NormAccumulator total;
    for (const NormAccumulator& sum : sums[i]) total.merge(sum);
    out[i] = total.cost(fitness);
  }
}

}  // namespace lacuna
