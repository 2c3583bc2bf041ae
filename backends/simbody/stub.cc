#include "backends/missing_engine.h"
#include "backends/registry.h"

namespace lacuna {

const Engine& simbody_engine() {
  static const MissingEngine engine("simbody", "libsimbody-dev", "LACUNA_WITH_SIMBODY");
  return engine;
}

}  // namespace lacuna
