#include "diagnosis/when.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ga/least_squares.h"

namespace lacuna {
namespace {

constexpr double kWindow = 1.0;        // s
constexpr double kFamilyError = 1e-3;  // of one false second in a diagnosis

struct Window {
  const Segment* segment;
  int channel;
  double begin, end;  // s
  Eigen::Index first, count;
};

/// A block's samples, second by second. Missing samples have no row.
void cut(const ResidualBlock& block, const Segment& segment, std::vector<Window>& out) {
  const auto& column = segment.measured[static_cast<std::size_t>(block.channel)];
  Eigen::Index row = block.first;
  const std::size_t start = out.size();
  for (std::size_t k = 0; k < column.size() && row < block.first + block.count; ++k) {
    if (!std::isfinite(column[k])) continue;
    const double t = segment.time(k);
    if (out.size() == start || t >= out.back().begin + kWindow) {
      if (out.size() > start) out.back().end = t;
      out.push_back({&segment, block.channel, t, t, row, 0});
    }
    out.back().end = t;
    ++out.back().count;
    ++row;
  }
}

bool continues(const Misfit& before, const Misfit& next) {
  return before.recording == next.recording && before.joint == next.joint && next.begin <= before.end + 1e-9;
}

void join(Misfit& last, const Misfit& next) {
  const double before = last.end - last.begin, more = next.end - next.begin;
  last.ratio =
      std::sqrt((last.ratio * last.ratio * before + next.ratio * next.ratio * more) / std::max(before + more, 1e-12));
  last.end = next.end;
  last.p_value = std::min(last.p_value, next.p_value);
}

/// The `kMostMisfits` of most energy, that first.
std::vector<Misfit> largest(const std::vector<Misfit>& all, const std::vector<double>& energies) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return energies[a] > energies[b]; });
  if (order.size() > kMostMisfits) order.resize(kMostMisfits);
  std::vector<Misfit> out;
  for (const std::size_t k : order) out.push_back(all[k]);
  return out;
}

}  // namespace

std::vector<Misfit> misfits(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks,
                            std::span<const double> noise_over_weight, std::span<const int> channel_joints,
                            const Experiment& experiment) {
  std::vector<Window> windows;
  for (const ResidualBlock& block : blocks) {
    if (noise_over_weight[static_cast<std::size_t>(block.channel)] > 0.0)
      cut(block, experiment.segments[static_cast<std::size_t>(block.segment)], windows);
  }
  std::vector<Misfit> out;
  std::vector<double> energies;
  for (const Window& w : windows) {
    const std::size_t c = static_cast<std::size_t>(w.channel);
    const ResidualBlock block{0, w.channel, w.first, w.count};
    const double noise = noise_over_weight[c], n = std::max(effective_samples(residual, std::span(&block, 1)), 1.0);
    const double energy = residual.segment(w.first, w.count).squaredNorm() / (noise * noise);
    const double ratio = energy / static_cast<double>(w.count);
    const double p = std::min(1.0, chance_of_energy(ratio, n) * static_cast<double>(windows.size()));
    if (p > kFamilyError) continue;
    Misfit found{w.segment->file,  experiment.joint_names[static_cast<std::size_t>(channel_joints[c])],
                 w.begin,          w.end,
                 std::sqrt(ratio), p};
    if (!out.empty() && continues(out.back(), found)) {
      join(out.back(), found);
      energies.back() += energy;
    } else {
      out.push_back(std::move(found));
      energies.push_back(energy);
    }
  }
  return largest(out, energies);
}

}  // namespace lacuna
