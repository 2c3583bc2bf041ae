#include "diagnosis/where.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/candidates.h"
#include "diagnosis/regions.h"

namespace lacuna {
namespace {

constexpr std::size_t kMost = 3;                       // of each kind
constexpr double kTelling = 1.3, kTellingShare = 0.1;  // share over its usual one; share

/// Energy that the effect removes from one channel of one segment, sample by sample.
struct Removed {
  const Segment* segment;
  std::size_t joint;
  std::vector<std::size_t> samples;
  std::vector<double> energy;
};

std::vector<Removed> removed_energy(const std::string& place, const CurrentModel& before, const CurrentModel& after,
                                    const FitContext& context) {
  const Experiment& experiment = context.experiment;
  const std::vector<int> validate = experiment.with_role(Role::validate);
  Problem a = problem_of(before, context);
  Problem b = problem_of(after, context, before.weights);
  const Eigen::VectorXd r0 = a.residual(before.fit.point, validate), r1 = b.residual(after.fit.point, validate);
  const auto& names = experiment.joint_names;
  const bool at_joint = std::find(names.begin(), names.end(), place) != names.end();
  std::vector<Removed> out;
  for (const ResidualBlock& block : a.layout(validate)) {
    const Segment& segment = experiment.segments[block.segment];
    const std::size_t channel = block.channel;
    const std::size_t joint = experiment.channels[channel].joint;
    if (at_joint && names[joint] != place) continue;
    Removed here{&segment, joint, {}, {}};
    Eigen::Index row = block.first;
    for (std::size_t k = 0; k < segment.measured[channel].size(); ++k) {
      if (!std::isfinite(segment.measured[channel][k])) continue;
      here.samples.push_back(k);
      here.energy.push_back(r0(row) * r0(row) - r1(row) * r1(row));
      ++row;
    }
    out.push_back(std::move(here));
  }
  return out;
}

std::vector<Finding::Interval> best_seconds(const std::vector<Removed>& removed) {
  std::map<std::pair<std::string, long>, double> seconds;
  for (const Removed& r : removed)
    for (std::size_t k = 0; k < r.samples.size(); ++k)
      seconds[{r.segment->file, static_cast<long>(std::floor(r.segment->time(r.samples[k])))}] += r.energy[k];
  std::vector<std::pair<double, Finding::Interval>> order;
  for (const auto& [key, energy] : seconds) {
    const auto begin = static_cast<double>(key.second);
    if (energy > 0.0) order.push_back({energy, {key.first, begin, begin + 1.0}});
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<Finding::Interval> out;
  for (std::size_t k = 0; k < std::min(kMost, order.size()); ++k) out.push_back(order[k].second);
  return out;
}

/// One region: energy removed and samples in it.
struct Portion {
  double energy = 0.0, samples = 0.0;
};

std::vector<std::string> telling_regions(const std::string& place, const std::vector<Removed>& removed,
                                         const Experiment& experiment) {
  const std::vector<int> measured = position_channels(experiment);
  std::map<std::string, Portion> portions;
  Portion all;
  for (std::size_t joint = 0; joint < measured.size(); ++joint) {
    if (measured[joint] < 0) continue;
    JointStates states;
    std::vector<double> energy;
    for (const Removed& r : removed) {
      if (r.joint != joint) continue;
      states.append(joint_states(experiment, *r.segment, joint, r.samples));
      energy.insert(energy.end(), r.energy.begin(), r.energy.end());
    }
    for (const double e : energy) all.energy += e, all.samples += 1.0;
    for (const Region& region : regions_of(experiment, joint, states))
      for (std::size_t k = 0; k < energy.size(); ++k)
        if (region.holds(states, k)) portions[region.words].energy += energy[k], portions[region.words].samples += 1.0;
  }
  if (!(all.energy > 0.0)) return {};
  std::vector<std::pair<double, std::string>> telling;
  for (const auto& [words, portion] : portions) {
    const double share = portion.energy / all.energy, usual = portion.samples / all.samples;
    if (share > kTelling * usual && share > kTellingShare)
      telling.emplace_back(share / usual, fmt::format("{} {}: {:.0f} % of what it removes in {:.0f} % of the samples",
                                                      place, words, 100.0 * share, 100.0 * usual));
  }
  std::stable_sort(telling.begin(), telling.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<std::string> out;
  for (std::size_t k = 0; k < std::min(kMost, telling.size()); ++k) out.push_back(telling[k].second);
  return out;
}

}  // namespace

void describe_evidence(Finding& finding, const CurrentModel& before, const CurrentModel& after,
                       const FitContext& context) {
  if (std::holds_alternative<InverseDynamics>(context.experiment.prediction)) return;
  const std::vector<Removed> removed = removed_energy(finding.place, before, after, context);
  finding.times = best_seconds(removed);
  finding.regions = telling_regions(finding.place, removed, context.experiment);
}

}  // namespace lacuna
