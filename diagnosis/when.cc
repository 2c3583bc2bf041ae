#include "diagnosis/when.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ga/least_squares.h"

namespace lacuna {
namespace {

constexpr double kWindow = 1.0;        // s
constexpr double kChangeError = 1e-3;  // of one false second in a diagnosis

constexpr std::size_t kShortestStretch = 20;  // samples between two changes
constexpr double kLeastChange = 1.5;          // of powers

struct Window {
  const Segment* segment;
  int channel;
  double begin, end;  // s
  Eigen::Index first, count;
};

/// A block's samples, second by second. Missing samples have no row.
void cut(const ResidualBlock& block, const Segment& segment, std::vector<Window>& out) {
  const auto& column = segment.measured[block.channel];
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
  out.reserve(order.size());
  for (const std::size_t k : order) out.push_back(all[k]);
  return out;
}

/// Where the cumulated sum of x about its mean is farthest from 0, `kShortestStretch` from the ends; and how far.
std::pair<Eigen::Index, double> farthest(const Eigen::Ref<const Eigen::VectorXd>& x) {
  const auto margin = static_cast<Eigen::Index>(kShortestStretch);
  const double mean = x.size() > 0 ? x.mean() : 0.0;
  double sum = 0.0;
  std::pair<Eigen::Index, double> out{0, 0.0};
  for (Eigen::Index k = 1; k <= x.size() - margin; ++k) {
    sum += x(k - 1) - mean;
    if (k >= margin && std::fabs(sum) > out.second) out = {k, std::fabs(sum)};
  }
  return out;
}

/// x about its mean, or about those of up to four parts that differ most: what a change adds to the variance is no
/// colour.
void level(Eigen::Ref<Eigen::VectorXd> x, int splits = 2) {
  const Eigen::Index at = splits > 0 ? farthest(x).first : 0;
  if (at == 0) {
    if (x.size() > 0) x.array() -= x.mean();
    return;
  }
  level(x.head(at), splits - 1);
  level(x.tail(x.size() - at), splits - 1);
}

/// The likeliest change in [begin, end), and its chance.
PowerChange likeliest_change(const Eigen::VectorXd& squares, std::size_t begin, std::size_t end, double tests) {
  const auto n = static_cast<Eigen::Index>(end - begin);
  Eigen::VectorXd part = squares.segment(begin, n);
  const auto [at, most] = farthest(part);
  level(part);
  const ResidualBlock block{0, 0, 0, n};
  const double variance =
      part.squaredNorm() / effective_samples(part, std::span(&block, 1));  // long-run, of one sample
  // The largest distance of a Brownian bridge from 0, Kolmogorov's law; its first term bounds it from above.
  const double distance = most / std::sqrt(static_cast<double>(n) * std::max(variance, 1e-300));
  PowerChange out;
  out.at = begin + static_cast<std::size_t>(at);
  out.p_value = at > 0 ? std::min(1.0, tests * 2.0 * std::exp(-2.0 * distance * distance)) : 1.0;
  return out;
}

double rms_of(const Eigen::VectorXd& squares, std::size_t begin, std::size_t end) {
  return std::sqrt(squares.segment(begin, end - begin).mean());
}

}  // namespace

std::vector<PowerChange> power_changes(std::span<const double> signal, double signals) {
  const double tests =
      signals * std::max(1.0, static_cast<double>(signal.size()) / static_cast<double>(kShortestStretch));
  if (signal.empty()) return {};
  const Eigen::Map<const Eigen::VectorXd> mapped(signal.data(), signal.size());
  const Eigen::VectorXd squares = mapped.cwiseAbs2();
  std::vector<PowerChange> out;
  const auto split = [&](auto&& self, std::size_t begin, std::size_t end) -> void {
    if (end - begin < 2 * kShortestStretch) return;
    const PowerChange change = likeliest_change(squares, begin, end, tests);
    if (!(change.p_value < kChangeError)) return;
    self(self, begin, change.at);
    out.push_back(change);
    self(self, change.at, end);
  };
  split(split, 0, signal.size());
  const auto measure = [&] {
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].before = rms_of(squares, k > 0 ? out[k - 1].at : 0, out[k].at);
      out[k].after = rms_of(squares, out[k].at, k + 1 < out.size() ? out[k + 1].at : signal.size());
    }
  };
  const auto slight = [](const PowerChange& c) {
    return std::max(c.before, c.after) < std::sqrt(kLeastChange) * std::min(c.before, c.after);
  };
  measure();
  for (auto c = std::find_if(out.begin(), out.end(), slight); c != out.end();
       c = std::find_if(out.begin(), out.end(), slight)) {
    out.erase(c);
    measure();
  }
  return out;
}

std::vector<Misfit> misfits(const Eigen::VectorXd& residual, std::span<const ResidualBlock> blocks,
                            std::span<const double> noise_over_weight, std::span<const int> channel_joints,
                            const Experiment& experiment) {
  std::vector<Window> windows;
  for (const ResidualBlock& block : blocks) {
    if (noise_over_weight[block.channel] > 0.0) cut(block, experiment.segments[block.segment], windows);
  }
  std::vector<Misfit> out;
  std::vector<double> energies;
  for (const Window& w : windows) {
    const std::size_t c = w.channel;
    const ResidualBlock block{0, w.channel, w.first, w.count};
    const double noise = noise_over_weight[c], n = std::max(effective_samples(residual, std::span(&block, 1)), 1.0);
    const double energy = residual.segment(w.first, w.count).squaredNorm() / (noise * noise);
    const double ratio = energy / static_cast<double>(w.count);
    const double p = std::min(1.0, chance_of_energy(ratio, n) * static_cast<double>(windows.size()));
    if (p > kChangeError) continue;
    Misfit found{w.segment->file, experiment.joint_names[channel_joints[c]], w.begin, w.end, std::sqrt(ratio), p};
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
