// What all fits to the same recordings share, handed on as one: the recordings, how they are simulated, and how the run
// is watched and stopped.
//
// A view that is cheap to copy: a search keeps its own, whose step becomes finer or coarser on the way.
#pragma once

#include "ga/optimizer.h"
#include "physics/simulator.h"

namespace lacuna {

struct FitContext {
  const Experiment& experiment;  ///< must outlive it; train recordings are fitted, validate ones weigh
  SimulatorOptions simulator;    ///< engine, threads, and the step that the present model needs
  RunControl control = {};       ///< looked at by every fit and search on the way

  /// The same at another step, s.
  FitContext with_step(double step) const;
  /// The same of other recordings, which must outlive what is returned.
  FitContext on(const Experiment& other) const { return {other, simulator, control}; }
};

inline FitContext FitContext::with_step(double step) const {
  FitContext out = *this;
  out.simulator.max_step = step;
  return out;
}

}  // namespace lacuna
