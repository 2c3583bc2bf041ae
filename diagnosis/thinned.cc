#include "diagnosis/thinned.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace lacuna {
namespace {

/// From one kind to the next the windows begin elsewhere, spread as evenly as any number of them can be: starts and
/// ends of short motions are seen as often as their middles.
constexpr double kGoldenRatio = 0.6180339887498949;
constexpr double kLevels = 3.0;  ///< of a command either way, up to its largest

/// A recording, and of each joint the least and the largest command in levels; at rest no recording.
using Kind = std::pair<std::string, std::vector<int>>;

std::vector<double> largest_commands(const Experiment& experiment) {
  std::vector<double> out(experiment.joint_names.size(), 0.0);
  for (const Segment& s : experiment.segments) {
    if (s.commands == nullptr) continue;
    for (std::size_t j = 0; j < out.size(); ++j)
      for (const double u : s.commands->value[j]) out[j] = std::max(out[j], std::fabs(u));
  }
  return out;
}

Kind kind_of(const Segment& s, const std::vector<double>& largest) {
  Kind out{s.file, {}};
  bool rests = true;
  for (std::size_t j = 0; j < largest.size() && s.commands != nullptr; ++j) {
    const auto first = s.commands->value[j].begin() + static_cast<std::ptrdiff_t>(s.first);
    const auto [low, high] = std::minmax_element(first, first + static_cast<std::ptrdiff_t>(s.count));
    const double level = largest[j] > 0.0 ? kLevels / largest[j] : 0.0;
    for (const double u : {*low, *high}) {
      out.second.push_back(static_cast<int>(std::lround(u * level)));
      rests = rests && u == 0.0;
    }
  }
  if (rests) out.first.clear();
  return out;
}

/// How many of each kind may stay so that about `budget` do, all kinds alike; may be less than one.
double level_for(const std::map<Kind, std::vector<std::size_t>>& kinds, double budget) {
  std::vector<double> sizes;
  for (const auto& [kind, members] : kinds) sizes.push_back(static_cast<double>(members.size()));
  std::sort(sizes.begin(), sizes.end());
  double left = budget;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const double level = left / static_cast<double>(sizes.size() - k);
    if (level <= sizes[k]) return level;
    left -= sizes[k];
  }
  return HUGE_VAL;
}

/// Marks what stays of the segments with a role.
void keep(const Experiment& experiment, Role role, double share, const std::vector<double>& largest,
          std::vector<bool>& kept) {
  std::map<Kind, std::vector<std::size_t>> kinds;
  std::map<std::string, std::vector<std::size_t>> files;
  for (const int s : experiment.with_role(role)) {
    const auto i = static_cast<std::size_t>(s);
    kinds[kind_of(experiment.segments[i], largest)].push_back(i);
    files[experiment.segments[i].file].push_back(i);
  }
  const double level = level_for(kinds, share * static_cast<double>(experiment.with_role(role).size()));
  double phase = 0.5;
  for (const auto& [kind, members] : kinds) {
    const double count = static_cast<double>(members.size());
    const double stay = std::min(count, std::floor(level + phase));
    for (double k = 0.0; k < stay; ++k) kept[members[static_cast<std::size_t>((k + phase) * count / stay)]] = true;
    phase = std::fmod(phase + kGoldenRatio, 1.0);
  }
  for (const auto& [file, members] : files)
    if (std::none_of(members.begin(), members.end(), [&](std::size_t s) { return kept[s]; }))
      kept[members[members.size() / 2]] = true;
}

}  // namespace

Experiment thinned(const Experiment& experiment, std::size_t most) {
  const std::size_t all = experiment.sample_count(Role::train);
  if (all <= most) return experiment;
  const double share = static_cast<double>(most) / static_cast<double>(all);
  const std::vector<double> largest = largest_commands(experiment);
  std::vector<bool> kept(experiment.segments.size(), false);
  for (const Role role : {Role::train, Role::validate}) keep(experiment, role, share, largest, kept);
  Experiment out = experiment;
  out.segments.clear();
  for (std::size_t s = 0; s < kept.size(); ++s)
    if (kept[s] || experiment.segments[s].role == Role::test) out.segments.push_back(experiment.segments[s]);
  return out;
}

}  // namespace lacuna
