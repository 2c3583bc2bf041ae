#include "reports/json_text.h"

#include <nlohmann/json.hpp>

namespace lacuna {

std::string json_text(const nlohmann::ordered_json& record) {
  return record.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace lacuna
