#include "diagnosis/thinned.h"

#include <cmath>
#include <map>
#include <utility>

namespace lacuna {
namespace {

/// From one recording to the next the windows begin elsewhere, spread as evenly as any number of them can be: starts
/// and ends of short motions are seen as often as their middles.
constexpr double kGoldenRatio = 0.6180339887498949;

}  // namespace

Experiment thinned(const Experiment& experiment, std::size_t most) {
  const std::size_t all = experiment.sample_count(Role::train);
  if (all <= most) return experiment;
  const double share = static_cast<double>(most) / static_cast<double>(all);
  std::map<std::pair<std::string, Role>, std::vector<std::size_t>> of_file;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s)
    of_file[{experiment.segments[s].file, experiment.segments[s].role}].push_back(s);
  std::vector<bool> kept(experiment.segments.size(), false);
  double phase = 0.5;
  for (const auto& [file, segments] : of_file) {
    const double count = static_cast<double>(segments.size());
    const double keep = file.second == Role::test ? count : std::max(1.0, std::round(share * count));
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
