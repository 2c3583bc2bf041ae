// How every record is written: two spaces deep, a line at the end, text that is not UTF-8 replaced.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lacuna {

std::string json_text(const nlohmann::ordered_json& record);

}  // namespace lacuna
