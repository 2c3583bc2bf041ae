#include "diagnosis/valve_comparison.h"

#include <cmath>
#include <numeric>

namespace lacuna {
namespace {

/// What the model simulates in place of what was measured; what is missing stays missing.
Experiment as_simulated(const CurrentModel& current, const FitContext& context) {
  Experiment out = context.experiment;
  std::vector<int> all(context.experiment.segments.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<std::vector<double>> one{current.space.expand(current.fit.point)};
  make_simulator(current.model, context.experiment, context.simulator)
      ->run(one, all, [&](int, int s, const std::vector<std::vector<double>>& predicted) {
        std::vector<std::vector<double>>& measured = out.segments[s].measured;
        for (std::size_t c = 0; c < measured.size(); ++c)
          for (std::size_t k = 0; k < measured[c].size(); ++k)
            if (!std::isnan(measured[c][k])) measured[c][k] = predicted[c][k];
      });
  return out;
}

}  // namespace

std::vector<ValveComparison> compare_valves(const CurrentModel& current, const FitContext& context) {
  std::vector<ValveComparison> out;
  std::vector<ValveChart> recorded = valve_charts(current.model, context.experiment);
  if (recorded.empty()) return out;
  const Experiment simulated = as_simulated(current, context);
  for (ValveChart& chart : recorded) {
    const int joint = chart.joint;
    out.push_back({std::move(chart), valve_chart(simulated, joint, true, true)});
  }
  return out;
}

}  // namespace lacuna
