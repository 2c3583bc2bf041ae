// The bundled scenarios of comparison, for the tests of this room and of consistency.
#pragma once

#include <string>

#include "scenarios/scenario.h"

namespace lacuna::test {

/// One of scenarios/compare/.
inline Scenario compared_scenario(const std::string& name) {
  return load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/compare/" + name + "/scenario.yaml");
}

}  // namespace lacuna::test
