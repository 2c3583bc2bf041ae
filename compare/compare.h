// The comparison of engines on one scenario: every measurement of this room, in order.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/runner.h"

namespace lacuna {

struct CompareOptions {
  std::vector<std::string> engines;  ///< built-in ones
  double duration = 5.0;             ///< s, the longest motion where the scenario does not state one
  bool identify = true;              ///< also identify on every engine with every engine's data
  std::uint64_t seed = 1;
  int threads = 1;
  const StopFlag* stop = nullptr;
  std::function<void(const std::string& stage, double done)> progress;
};

/// What an engine's own run at the comparison's step looks like, for pictures.
struct EngineRun {
  std::string engine, method;
  std::vector<double> times;  ///< s
  Trajectory run;
};

/// `scenario` holds no recording or the one whose commands are run, loaded. Engines that cannot hold the robot are
/// recorded with the reason. `runs`, where not null, receives the referee's run, then one of every engine that stays
/// finite. Throws InputError, WorkError where no engine can be compared or the motion diverges, Interrupted.
ScenarioComparison compare_engines(const Scenario& scenario, const CompareOptions& options,
                                   std::vector<EngineRun>* runs = nullptr);

}  // namespace lacuna
