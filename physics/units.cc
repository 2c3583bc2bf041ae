#include "physics/units.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

namespace lacuna {
namespace {

std::string linear_for(const std::string& unit) {
  static const std::vector<std::pair<std::string, std::string>> kLinear = {{"N m/V", "N/V"},
                                                                           {"N m s/rad", "N s/m"},
                                                                           {"N m/rad", "N/m"},
                                                                           {"rad/(s V)", "m/(s V)"},
                                                                           {"rad/s", "m/s"},
                                                                           {"rad", "m"},
                                                                           {"N m", "N"},
                                                                           {"N m s^2/rad^2", "N s^2/m^2"},
                                                                           {"N m/rad^3", "N/m^3"},
                                                                           {"kg m^2", "kg"},
                                                                           {"N m (s/rad)^p", "N (s/m)^p"},
                                                                           {"1/rad", "1/m"},
                                                                           {"m/rad", "1"}};
  for (const auto& [angular, straight] : kLinear) {
    if (unit == angular) return straight;
  }
  return unit;
}

/// Where the volts stand in it, npos where nowhere.
std::size_t volts_in(const std::string& unit) {
  const auto letter = [&](std::size_t k) {
    return k < unit.size() && std::isalpha(static_cast<unsigned char>(unit[k])) != 0;
  };
  for (std::size_t k = 0; k < unit.size(); ++k) {
    if (unit[k] == 'V' && !letter(k + 1) && (k == 0 || !letter(k - 1))) return k;
  }
  return std::string::npos;
}

}  // namespace

std::string command_unit(const Scenario& scenario, const std::string& joint) {
  const auto commands = scenario.channels.of.find(ChannelKind::command);
  if (commands != scenario.channels.of.end()) {
    const auto column = commands->second.find(joint);
    if (column != commands->second.end() && !column->second.unit.empty()) return column->second.unit;
  }
  for (const ActuatorSpec& actuator : scenario.actuators) {
    if (actuator.joint != joint || actuator.model != "direct_effort") continue;
    const auto gain = actuator.parameters.find("gain");
    const auto index = scenario.robot->find_joint(joint);
    if (gain != actuator.parameters.end() && gain->second == 1.0 && index)
      return unit_at("N m", scenario.robot->joints()[*index].prismatic(), kAnyCommand);
  }
  return kAnyCommand;
}

std::string unit_at(const std::string& unit, bool prismatic, const std::string& command) {
  const std::string own = prismatic ? linear_for(unit) : unit;
  const std::size_t at = volts_in(own);
  if (at == std::string::npos) return own;
  const bool divides = at > 0 && own[at - 1] == '/';
  if (divides && own.substr(0, at - 1) == command && at + 1 == own.size()) return "1";
  const bool compound = command.find('/') != std::string::npos || (divides && command.find(' ') != std::string::npos);
  const bool alone = own.size() == 1;
  return own.substr(0, at) + (compound && !alone ? "(" + command + ")" : command) + own.substr(at + 1);
}

}  // namespace lacuna
