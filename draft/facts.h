// Everything that was found out about a robot's recordings, before it is written down (draft/page.h).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "draft/actuation.h"
#include "draft/clock.h"
#include "draft/columns.h"
#include "draft/draft.h"
#include "draft/roles.h"
#include "draft/units.h"

namespace lacuna {

/// A measured signal as it came, SI.
struct SignalFacts {
  double low = 0.0, high = 0.0, rest = 0.0;  ///< range; where the first recording begins
  double noise = 0.0;                        ///< rms; NaN: not to be seen
  double step = 0.0;                         ///< of quantisation; 0: none to be seen
};

struct DraftFacts {
  ClockGuess clock;         ///< of all recordings: the least even one's spacings
  bool one_period = false;  ///< every recording is even, all with one period
  ColumnGuesses columns;
  std::map<std::pair<ChannelKind, int>, UnitGuess> units;  ///< by kind and joint
  std::map<int, SignalFacts> positions;                    ///< by joint
  ActuationGuess actuation;
  RoleGuesses roles;
  Prediction prediction;
  std::string prediction_reason;

  bool measured(ChannelKind kind, int joint) const { return columns.find(kind, joint) != nullptr; }
};

/// The text; appends to `guesses` and `questions` of `out` what it says in comments.
void write_page(const DraftRequest& request, const DraftFacts& facts, Draft& out);

}  // namespace lacuna
