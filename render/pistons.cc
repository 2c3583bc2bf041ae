#include "render/pistons.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenarios/robot.h"
#include "scenarios/scenario.h"

namespace lacuna {

std::vector<Piston> pistons_of(const Scenario& scenario) {
  std::vector<Piston> out;
  for (const ActuatorSpec& actuator : scenario.actuators) {
    const auto of = [&](const char* name) {
      const auto at = actuator.parameters.find(name);
      return at == actuator.parameters.end() ? 0.0 : at->second;
    };
    const double a = of("lever_a"), b = of("lever_b"), area = of("area_a"), ring = of("area_b");
    if (!(a * b > 0.0) || !(area > 0.0)) continue;
    const double middle = of("middle") + of("lever_angle");
    const double half_way = std::sqrt(std::max(0.0, a * a + b * b - 2.0 * a * b * std::cos(middle)));
    const auto diameter = [](double disc) { return 2.0 * std::sqrt(std::max(0.0, disc) / std::numbers::pi); };
    const double shortest = half_way - 0.5 * of("stroke");
    out.push_back({scenario.robot->find_joint(actuator.joint).value_or(-1), a, b, of("lever_angle"),
                   0.95 * std::max(shortest, 0.1 * half_way), diameter(std::max(area, ring)),
                   std::max(diameter(area - ring), 0.2 * diameter(area))});
  }
  return out;
}

}  // namespace lacuna
