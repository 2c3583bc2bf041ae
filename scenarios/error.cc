#include "scenarios/error.h"

#include "scenarios/text.h"

namespace lacuna {

std::string quoted(const std::string& text, std::size_t limit) { return '"' + printable(text, limit) + '"'; }

}  // namespace lacuna
