// The catalogue: one file and one entry here per effect. Command effects act in this order.
#pragma once

#include "physics/effects/actuator_saturation.h"
#include "physics/effects/coulomb_friction.h"
#include "physics/effects/input_delay.h"
#include "physics/effects/payload.h"
#include "physics/effects/stribeck_friction.h"
#include "physics/effects/valve_deadband.h"
#include "physics/effects/valve_offset.h"

namespace lacuna {

using Effects = ComponentList<InputDelay, ValveOffset, ValveDeadband, ActuatorSaturation, CoulombFriction,
                              StribeckFriction, Payload>;

}  // namespace lacuna
