// `lacuna compare SCENARIO --simulators A,B`: engine A's recordings by its own stepping, diagnosed on engine B.
#pragma once

#include <string>
#include <vector>

#include "cli/command.h"

namespace lacuna {

struct SimulatorFlags {
  std::string engines;         ///< "A,B"; empty: not asked for
  std::string integrator;      ///< of A; empty: its default
  double step = 2e-3;          ///< s, of A
  double own_friction = 0.05;  ///< of gain times rms command, where the scenario states no friction
};

/// `--simulators` and the options that go with it.
void add_simulator_options(CLI::App& command, SimulatorFlags& flags);

/// Writes simulators.json and report.html to the session's folder, and the two cases that were diagnosed, complete with
/// their diagnoses, to `step` and `half_step` below it. Prints a table. Throws InputError, WorkError, Interrupted.
void run_simulators(Session& session, const SimulatorFlags& flags);

}  // namespace lacuna
