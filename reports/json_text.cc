#include "reports/json_text.h"

#include <nlohmann/json.hpp>

namespace lacuna {

std::string json_text(const nlohmann::ordered_json& record) {
  return record.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string script_json(const nlohmann::ordered_json& record) {
  const std::string plain = record.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  out.reserve(plain.size());
  // They stand in strings only, where JSON allows them to be written so.
  for (const char c : plain) {
    switch (c) {
      case '<': out += "\\u003c"; break;
      case '>': out += "\\u003e"; break;
      case '&': out += "\\u0026"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace lacuna
