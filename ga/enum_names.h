// Names of enumerators, for options on the command line, in scenarios and in results: one table per enumeration.
#pragma once

#include <array>
#include <stdexcept>
#include <string>

namespace lacuna {

/// The enumerator called `name`, where names[i] belongs to the enumerator of value i. Throws std::invalid_argument with
/// the option, the name found and the names allowed.
template <typename Enum, std::size_t n>
Enum enum_from_name(const std::string& option, const std::array<const char*, n>& names, const std::string& name) {
  std::string allowed;
  for (std::size_t i = 0; i < n; ++i) {
    if (name == names[i]) return static_cast<Enum>(i);
    allowed += (i == 0 ? "" : ", ") + std::string(names[i]);
  }
  throw std::invalid_argument(option + " = " + name + ", allowed: " + allowed);
}

}  // namespace lacuna
