#include "backends/missing_engine.h"
#include "backends/registry.h"

namespace lacuna {

const Engine& ode_engine() {
  static const MissingEngine engine("ode", "libode-dev", "LACUNA_WITH_ODE");
  return engine;
}

}  // namespace lacuna
