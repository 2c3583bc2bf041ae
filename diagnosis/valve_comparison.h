// The charts of speed against command (valve_chart.h) of the recordings and of a model's own simulations of them, side
// by side: where a curve of the model's valve differs, and what a map that knows no law leaves beside it.
#pragma once

#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/valve_chart.h"
#include "physics/simulator.h"

namespace lacuna {

struct ValveComparison {
  ValveChart recorded, simulated;
};

/// Of every joint that has a chart.
std::vector<ValveComparison> compare_valves(const CurrentModel& current, const FitContext& context);

}  // namespace lacuna
