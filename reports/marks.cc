#include "reports/marks.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "reports/json_text.h"
#include "reports/packed.h"

namespace lacuna {

std::string Marks::add(const std::string& joint, std::vector<Time> times) {
  marks_.push_back({joint, std::move(times)});
  return fmt::format("mark mark-{}", marks_.size() - 1);
}

Html Marks::data() const {
  if (marks_.empty()) return {};
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Mark& mark : marks_) {
    nlohmann::ordered_json times = nlohmann::ordered_json::array();
    for (const Time& t : mark.times) times.push_back({t.recording, six_digits(t.begin), six_digits(t.end)});
    out.push_back({{"joint", mark.joint}, {"times", times}});
  }
  return data_block("marks-data", script_json(out));
}

}  // namespace lacuna
