// What may be missing: where an effect can act, what is searched of it there, and the present model with it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "ga/fit_context.h"
#include "ga/least_squares.h"
#include "physics/catalogue.h"

namespace lacuna {

/// The model under diagnosis as identified so far.
struct CurrentModel {
  PlantModel model;
  SearchSpace space;
  std::vector<double> weights;  ///< rms per predicted channel
  LeastSquaresResult fit;       ///< on the train segments
};

/// Its search problem on the context's recordings, in its own weights or in others. Model and recordings must outlive
/// it.
Problem problem_of(const CurrentModel& model, const FitContext& context);
Problem problem_of(const CurrentModel& model, const FitContext& context, std::vector<double> weights);

/// An effect at each place where it can show and does not stand yet: on a command or an actuator where there is one, on
/// a motion where it is measured and moves, on a reading where positions are predicted.
std::vector<EffectSpec> places_of(const EffectInfo& info, const CurrentModel& current, const Experiment& experiment);

/// What an effect at a joint is made of, where its form hangs on the size of the recordings
/// (ParameterInfo::structural).
std::map<std::string, double> form_of(const EffectInfo& info, const PlantModel& model, const Experiment& experiment,
                                      int joint);

/// Axes of an effect's own parameters in `model`, where it stands at `component`; those that `spec` names are fixed.
std::vector<Axis> effect_axes(const PlantModel& model, const Experiment& experiment, const Component& component,
                              const EffectSpec& spec);

/// Where a search for an effect's own numbers begins: every combination of their starting sizes, in search coordinates;
/// those of every joint go together.
std::vector<std::vector<double>> starting_points(const PlantModel& model, const Experiment& experiment,
                                                 const std::vector<Axis>& axes);

/// The current model with one more effect, its parameters as further axes; `own` are their start coordinates.
CurrentModel extended(const CurrentModel& current, const Experiment& experiment, const EffectSpec& spec,
                      const std::vector<double>& point, const std::vector<double>& own);

/// Whether one of the effects' numbers in `model` is as large as it must be to mean what its name says.
bool is_large_enough(const CurrentModel& current, const Experiment& experiment, const Axis& axis, double x);

/// Effects of a model that `plain` has not, in its order, with the numbers that are held fixed.
std::vector<EffectSpec> effects_beyond(const PlantModel& plain, const CurrentModel& current);

}  // namespace lacuna
