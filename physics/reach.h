// What a parameter can change of what is predicted.
#pragma once

#include <vector>

#include "physics/experiment.h"
#include "physics/plant_model.h"

namespace lacuna {

/// [parameter]: whether it changes predictions of its own joint alone although the joints move each other. So it is
/// where the motion is measured and efforts are predicted: what acts in a joint's drive, friction or transducer leaves
/// the needs of all other joints as they are. Not so what weighs, what tilts the base, and what joints share.
std::vector<bool> stays_at_its_joint(const PlantModel& model, const Prediction& prediction);

}  // namespace lacuna
