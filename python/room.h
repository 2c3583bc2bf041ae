// What the module is made of, one source each.
#pragma once

#include <pybind11/pybind11.h>

namespace lacuna {

void add_dynamics(pybind11::module_& module);   ///< engines(), Robot, Dynamics
void add_simulator(pybind11::module_& module);  ///< Scenario, Simulator, rollouts(), simulate()
void add_searches(pybind11::module_& module);   ///< identify(), diagnose(), diff()

}  // namespace lacuna
