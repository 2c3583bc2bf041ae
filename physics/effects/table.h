// The catalogue: one file and one entry here per effect. Effects on the command act in this order, those on a flow, on
// masses and on a reading too.
#pragma once

#include "physics/effects/actuator_lag.h"
#include "physics/effects/actuator_saturation.h"
#include "physics/effects/armature.h"
#include "physics/effects/backlash.h"
#include "physics/effects/base_compliance.h"
#include "physics/effects/base_tilt.h"
#include "physics/effects/com_shift.h"
#include "physics/effects/coulomb_asymmetry.h"
#include "physics/effects/coulomb_friction.h"
#include "physics/effects/damping_asymmetry.h"
#include "physics/effects/effort_scale.h"
#include "physics/effects/end_stop.h"
#include "physics/effects/gear_ripple.h"
#include "physics/effects/gravity_spring.h"
#include "physics/effects/hysteresis_friction.h"
#include "physics/effects/input_delay.h"
#include "physics/effects/joint_compliance.h"
#include "physics/effects/leakage.h"
#include "physics/effects/learned_command.h"
#include "physics/effects/learned_effort.h"
#include "physics/effects/learned_reading.h"
#include "physics/effects/lever_arm_variation.h"
#include "physics/effects/load_dependent_friction.h"
#include "physics/effects/oil_compressibility.h"
#include "physics/effects/orifice_load_dependence.h"
#include "physics/effects/payload.h"
#include "physics/effects/power_friction.h"
#include "physics/effects/quadratic_damping.h"
#include "physics/effects/relief.h"
#include "physics/effects/rigid_body.h"
#include "physics/effects/sensor_backlash.h"
#include "physics/effects/sensor_delay.h"
#include "physics/effects/sensor_offset.h"
#include "physics/effects/sensor_scale.h"
#include "physics/effects/shared_supply.h"
#include "physics/effects/stiffness_hardening.h"
#include "physics/effects/stribeck_friction.h"
#include "physics/effects/supply_pressure_sag.h"
#include "physics/effects/thermal_drift.h"
#include "physics/effects/torque_offset.h"
#include "physics/effects/valve_asymmetry.h"
#include "physics/effects/valve_deadband.h"
#include "physics/effects/valve_drift.h"
#include "physics/effects/valve_hysteresis.h"
#include "physics/effects/valve_offset.h"
#include "physics/effects/valve_opening.h"
#include "physics/effects/viscous_friction.h"

namespace lacuna {

using Effects =
    ComponentList<InputDelay, ValveOffset, ValveDrift, ValveDeadband, ValveOpening, ValveHysteresis, ActuatorSaturation,
                  ValveAsymmetry, LearnedCommand, ActuatorLag, SharedSupply, LeverArmVariation, SupplyPressureSag,
                  OrificeLoadDependence, Leakage, Relief, CoulombFriction, CoulombAsymmetry, StribeckFriction,
                  LoadDependentFriction, HysteresisFriction, ViscousFriction, PowerFriction, QuadraticDamping,
                  DampingAsymmetry, TorqueOffset, GravitySpring, StiffnessHardening, EndStop, OilCompressibility,
                  GearRipple, Backlash, JointCompliance, ThermalDrift, RigidBody, ComShift, Payload, Armature, BaseTilt,
                  BaseCompliance, SensorScale, SensorOffset, LearnedReading, SensorBacklash, SensorDelay, EffortScale,
                  LearnedEffort>;

}  // namespace lacuna
