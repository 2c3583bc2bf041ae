#include "diagnosis/thinned.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace lacuna {
namespace {

/// From one recording to the next the windows begin elsewhere, spread as evenly as any number of them can be: starts
/// and ends of short motions are seen as often as their middles.
constexpr double kGoldenRatio = 0.6180339887498949;

using File = std::pair<std::string, Role>;
using SegmentsOf = std::map<File, std::vector<std::size_t>>;  ///< segments of each recording and role

/// How many windows of each train recording hold `most` values together: short recordings have fewer, and all of them
/// are in.
double level(const Experiment& experiment, const SegmentsOf& windows, std::size_t most) {
  const double values = static_cast<double>(experiment.sample_count(Role::train)) /
                        static_cast<double>(experiment.with_role(Role::train).size());  // of one
  std::vector<double> counts;
  for (const auto& [file, segments] : windows)
    if (file.second == Role::train) counts.push_back(static_cast<double>(segments.size()));
  std::ranges::sort(counts);
  double left = static_cast<double>(most) / values;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const double share = left / static_cast<double>(counts.size() - k);
    if (share <= counts[k]) return share;
    left -= counts[k];
  }
  return counts.back();
}

}  // namespace

Experiment thinned(const Experiment& experiment, std::size_t most) {
  if (experiment.sample_count(Role::train) <= most) return experiment;
  SegmentsOf windows;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s)
    windows[{experiment.segments[s].file, experiment.segments[s].role}].push_back(s);
  const double share = level(experiment, windows, most);
  std::vector<bool> kept(experiment.segments.size(), false);
  double phase = 0.5;
  for (const auto& [file, segments] : windows) {
    const double count = static_cast<double>(segments.size());
    const double keep = file.second == Role::test ? count : std::clamp(std::floor(share + phase), 1.0, count);
    for (double k = 0.0; k < keep; ++k) kept[segments[static_cast<std::size_t>((k + phase) * count / keep)]] = true;
    phase = std::fmod(phase + kGoldenRatio, 1.0);
  }
  Experiment out = experiment;
  out.segments.clear();
  for (std::size_t s = 0; s < kept.size(); ++s)
    if (kept[s]) out.segments.push_back(experiment.segments[s]);
  return out;
}

}  // namespace lacuna
