// How near what a diagnosis learned comes to a law, or to events, that were hidden outside the catalogue.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "physics/outside.h"

namespace lacuna {

/// An entry of `learned[]`.
struct LearnedRecord {
  std::string place;
  LawRecord law;
};

struct LawScore {
  bool place = false, stage = false, over = false;  ///< some entry is right in this and in those before it
  /// Of the entry right in all three, the best where there are several; NaN where there is none with a curve.
  double curve_error = std::nan("");
  int events = 0, found = 0;  ///< hidden ones, and those at this place within kEventEdge at both ends
};
constexpr double kEventEdge = 0.1;  ///< s

/// Without what the label says of the law (`hidden` null), only the place is judged.
LawScore score_law(const std::string& place, const LawRecord* hidden, const std::vector<LearnedRecord>& learned);

/// rms over the hidden points of (learned - hidden), relative to the hidden curve's own, both after the constant and
/// what is linear in each variable were taken off: the plain parameters may hold any of these. The learned curve is
/// linear between its points and level beyond them; of two variables the second takes the nearest value that the curve
/// has. NaN without points or for a hidden line.
double curve_error(const LawRecord& hidden, const LawRecord& learned);

}  // namespace lacuna
