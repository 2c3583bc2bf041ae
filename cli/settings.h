// `--set joint_2.gain=210`: single numbers of a plant changed on the command line.
#pragma once

#include <string>
#include <vector>

#include "physics/plant_model.h"

namespace lacuna {

/// A plant and the values to simulate it with.
struct SetPlant {
  PlantModel model;
  std::vector<double> values;
};

/// The scenario's plant with `settings` ("name=value") put in. A parameter of an effect that the scenario does not have
/// ("joint_2.coulomb_friction.Fc") adds the effect, its other parameters neutral. Throws InputError for an unknown name
/// (naming near ones), a value that is no number or lies outside the parameter's range.
SetPlant plant_with(const Scenario& scenario, const std::vector<std::string>& settings);

}  // namespace lacuna
