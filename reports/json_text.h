// How every record is written: two spaces deep, a line at the end, text that is not UTF-8 replaced.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lacuna {

std::string json_text(const nlohmann::ordered_json& record);

/// In one line and in ASCII, for a script element of a page: no `<`, `>` or `&` stands in it as such, so that no name
/// can end the element or open another.
std::string script_json(const nlohmann::ordered_json& record);

}  // namespace lacuna
