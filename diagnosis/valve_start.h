// What a joint's chart of speed against command (valve_chart.h) shows of its valve, as effects of the catalogue: a
// valve curve is several of them at once, none of which explains much alone, and a wide dead zone is too far from none
// for any search that goes step by step. The fewest are taken that describe the chart nearly as well as all do. They
// are where a search of whole sets begins (set_search.h), and no claim.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/screen.h"
#include "diagnosis/valve_chart.h"
#include "scenarios/scenario.h"

namespace lacuna {

struct ValveStart {
  int joint = 0;
  double gain = 0.0;                ///< rad/(s V) (m/(s V))
  std::vector<EffectSpec> effects;  ///< in the order of the catalogue; all their numbers given
};

/// `spec` with all its numbers given, as a search has it: those that say what a law is made of fixed, and its optional
/// shape where that is neutral, a contact's stiffness where the drive's flow ends at it, the others free and begun at
/// these.
ScreenedEffect start_at(const CurrentModel& current, const Experiment& experiment, const EffectSpec& spec);

/// Of every joint that has a chart.
std::vector<ValveStart> valve_starts(const PlantModel& model, const Experiment& experiment);

}  // namespace lacuna
