#include "diagnosis/thinned.h"

#include <cmath>
#include <map>
#include <utility>

namespace lacuna {

Experiment thinned(const Experiment& experiment, std::size_t most) {
  const std::size_t all = experiment.sample_count(Role::train);
  if (all <= most) return experiment;
  const double share = static_cast<double>(most) / static_cast<double>(all);
  std::map<std::pair<std::string, Role>, std::vector<std::size_t>> of_file;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s)
    of_file[{experiment.segments[s].file, experiment.segments[s].role}].push_back(s);
  std::vector<bool> kept(experiment.segments.size(), false);
  for (const auto& [file, segments] : of_file) {
    const double count = static_cast<double>(segments.size());
    const double keep = file.second == Role::test ? count : std::max(1.0, std::round(share * count));
    for (double k = 0.0; k < keep; ++k) kept[segments[static_cast<std::size_t>((k + 0.5) * count / keep)]] = true;
  }
  Experiment out = experiment;
  out.segments.clear();
  for (std::size_t s = 0; s < kept.size(); ++s)
    if (kept[s]) out.segments.push_back(experiment.segments[s]);
  return out;
}

}  // namespace lacuna
