// What is hidden in a case, as it was asked for.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/outside.h"

namespace lacuna {

/// One `--effect`: a catalogue effect, or physics outside the catalogue.
struct HiddenEffect {
  std::string effect, place;
  std::vector<std::pair<std::string, double>> given;  ///< parameters with values; "" names the leading one
  std::optional<OutsidePhysics::Kind> outside;
  std::vector<std::string> recordings;  ///< files in which it acts; empty: all
};

/// "coulomb_friction:joint_2:25", "stribeck_friction:joint_2:Fc=8,Fs=12", "payload:arm". Throws InputError.
HiddenEffect parse_hidden_effect(const std::string& text);

}  // namespace lacuna
