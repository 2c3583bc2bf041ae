// Every actuator model: one file and one entry here.
#pragma once

#include "physics/actuators/direct_effort.h"
#include "physics/actuators/flow_source.h"
#include "physics/actuators/hydraulic.h"
#include "physics/actuators/torque_source.h"

namespace lacuna {

using Actuators = ComponentList<TorqueSource, FlowSource, DirectEffort, Hydraulic>;

}  // namespace lacuna
