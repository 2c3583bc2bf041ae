#include "backends/missing_engine.h"
#include "backends/registry.h"

namespace lacuna {

const Engine& mujoco_engine() {
  static const MissingEngine engine("mujoco", "libmujoco-dev", "LACUNA_WITH_MUJOCO");
  return engine;
}

}  // namespace lacuna
