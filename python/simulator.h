// A scenario's plant on one of its recordings, simulated with many parameter sets at once.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/simulator.h"

namespace lacuna {

struct PythonSimulatorOptions {
  std::string recording;           ///< as the scenario writes it; empty: the first
  std::vector<std::string> names;  ///< of the columns of parameters; empty: all parameters of the plant
  std::string engine = "featherstone";
  std::optional<double> step;  ///< s; absent: chosen by halving, for the scenario's own values
  int threads = 0;             ///< 0: all
};

/// Simulates one recording from its start to its end, whatever the scenario's prediction is. Immutable.
class PythonSimulator {
 public:
  /// Throws InputError for an unknown recording, name or engine, WorkError for an engine that is not built.
  PythonSimulator(const Scenario& scenario, PythonSimulatorOptions options, const StopFlag& stop);

  /// [set][sample][channel], flat; NaN or infinite where a simulation diverged. `sets`: one row of names() each. Throws
  /// InputError for a value out of its physical range, Interrupted.
  std::vector<double> rollouts(const std::vector<std::vector<double>>& sets, const StopFlag& stop) const;

  const std::vector<std::string>& names() const { return options_.names; }
  std::vector<double> values() const;  ///< the scenario's own, of names()
  std::vector<std::string> channels() const;
  std::vector<double> time() const;      ///< s, on the recording's own clock
  std::vector<double> measured() const;  ///< [sample][channel], flat
  double step() const { return step_; }
  const std::string& recording() const { return options_.recording; }
  std::size_t samples() const { return segment().measured.front().size(); }

 private:
  const Segment& segment() const { return experiment_.segments.front(); }
  std::vector<double> full(const std::vector<double>& set) const;
  double chosen_step(const StopFlag& stop) const;

  PythonSimulatorOptions options_;
  PlantModel model_;
  Experiment experiment_;
  std::vector<int> index_;  ///< of names() among the plant's parameters
  double step_ = 0.0;
};

}  // namespace lacuna
