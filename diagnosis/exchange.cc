#include "diagnosis/exchange.h"

#include <fmt/format.h>

#include "diagnosis/contest.h"

namespace lacuna {
namespace {

constexpr double kLead = 1.0;  ///< log-evidence that a rival must be ahead by to take the place

/// The finding as a rival of whatever takes its place.
Rival as_rival(const Finding& finding, const CurrentModel& current) {
  Rival out{finding.effect, finding.place, 0.0, finding.fixed, {}, finding.recordings};
  const int at = current.model.find_effect_at(finding.effect, finding.place);
  const Component& component = current.model.effects()[at];
  for (std::size_t a = 0; a < current.space.size(); ++a) {
    const int parameter = current.space.axes()[a].parameter;
    if (parameter >= component.first && parameter < component.first + component.count)
      out.own.push_back(current.fit.point[a]);
  }
  return out;
}

}  // namespace

std::vector<std::string> exchange(const CurrentModel& plain, CurrentModel& current, std::vector<Finding>& findings,
                                  const FitContext& context) {
  std::vector<std::string> changes;
  if (findings.size() < 2) return changes;
  for (std::size_t k = 0; k < findings.size(); ++k) {
    Finding& finding = findings[k];
    const std::vector<Entrant> entrants = contest(k, plain, current, findings, context);
    if (entrants.empty() || !(entrants.front().evidence > kLead)) continue;
    const Entrant& winner = entrants.front();
    changes.push_back(fmt::format("{} at {} gave way to {} at {}, which explains more beside the other findings",
                                  finding.effect, finding.place, winner.rival.effect, winner.rival.place));
    finding.rivals = {as_rival(finding, current)};
    for (std::size_t e = 1; e < entrants.size(); ++e) finding.rivals.push_back(entrants[e].rival);
    finding.effect = winner.rival.effect, finding.place = winner.rival.place;
    finding.fixed = winner.rival.fixed, finding.recordings = winner.rival.recordings;
    current = winner.model;
  }
  return changes;
}

}  // namespace lacuna
