// What `lacuna blind` writes of its cases.
#pragma once

#include <string>
#include <vector>

#include "reports/context.h"
#include "trial/score.h"

namespace lacuna {

/// `blind.json`, format lacuna-blind/1.
std::string to_json(const std::vector<BlindCase>& cases, const Context& context);
/// `report.html` beside it.
std::string blind_page(const std::vector<BlindCase>& cases, const std::string& folder, const Context& context);

}  // namespace lacuna
