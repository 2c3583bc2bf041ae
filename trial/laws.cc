#include "trial/laws.h"

#include <algorithm>
#include <map>

namespace lacuna {
namespace {

constexpr double kRounding = 1e-9;  // of a curve: what a line leaves of a line

using Row = std::vector<std::pair<double, double>>;  // a curve's values over its first variable, in its order

/// By the second variable; of a curve over one variable, all under 0.
std::map<double, Row> rows_of(const std::vector<LawRecord::Point>& curve) {
  std::map<double, Row> out;
  for (const LawRecord::Point& p : curve) out[p.at.size() > 1 ? p.at[1] : 0.0].emplace_back(p.at[0], p.value);
  for (auto& [second, row] : out) std::sort(row.begin(), row.end());
  return out;
}

const Row& nearest_row(const std::map<double, Row>& rows, double second) {
  const auto above = rows.lower_bound(second);
  if (above == rows.end()) return std::prev(above)->second;
  if (above == rows.begin()) return above->second;
  return (second - std::prev(above)->first < above->first - second ? std::prev(above) : above)->second;
}

double value_at(const Row& row, double x) {
  const auto above =
      std::lower_bound(row.begin(), row.end(), x, [](const auto& point, double place) { return point.first < place; });
  if (above == row.end()) return row.back().second;
  if (above == row.begin() || above->first == x) return above->second;
  const auto below = above - 1;
  return below->second + (above->second - below->second) * (x - below->first) / (above->first - below->first);
}

bool is_same(const LawRecord::Event& hidden, const LawRecord::Event& learned) {
  return hidden.recording == learned.recording && std::fabs(hidden.from - learned.from) <= kEventEdge &&
         std::fabs(hidden.to - learned.to) <= kEventEdge;
}

bool is_found(const LawRecord::Event& hidden, const std::string& place, const std::vector<LearnedRecord>& learned) {
  return std::any_of(learned.begin(), learned.end(), [&](const LearnedRecord& entry) {
    return entry.place == place && std::any_of(entry.law.events.begin(), entry.law.events.end(),
                                               [&](const auto& event) { return is_same(hidden, event); });
  });
}

}  // namespace

double curve_error(const LawRecord& hidden, const LawRecord& learned) {
  if (hidden.curve.empty() || learned.curve.empty()) return std::nan("");
  std::vector<std::vector<double>> at;
  std::vector<double> truth, off;
  const std::map<double, Row> rows = rows_of(learned.curve);
  for (const LawRecord::Point& p : hidden.curve) {
    at.push_back(p.at);
    truth.push_back(p.value);
    off.push_back(value_at(nearest_row(rows, p.at.size() > 1 ? p.at[1] : 0.0), p.at[0]) - p.value);
  }
  const double own = root_mean_square(beyond_linear(at, truth));
  return own > kRounding * root_mean_square(truth) ? root_mean_square(beyond_linear(at, off)) / own : std::nan("");
}

LawScore score_law(const std::string& place, const LawRecord* hidden, const std::vector<LearnedRecord>& learned) {
  LawScore out;
  for (const LearnedRecord& entry : learned) {
    if (entry.place != place) continue;
    out.place = true;
    if (hidden == nullptr || entry.law.stage != hidden->stage) continue;
    out.stage = true;
    if (entry.law.over != hidden->over) continue;
    out.over = true;
    const double error = curve_error(*hidden, entry.law);
    if (!(error >= out.curve_error)) out.curve_error = error;
  }
  if (hidden == nullptr) return out;
  out.events = static_cast<int>(hidden->events.size());
  for (const LawRecord::Event& event : hidden->events) out.found += is_found(event, place, learned);
  return out;
}

}  // namespace lacuna
