// A first scenario.yaml from a robot and its recordings: `lacuna init`.
//
// Columns are matched to joints by name (columns.h), clocks and units read off the numbers (clock.h, units.h),
// actuators and start values regressed on the motion (actuation.h), roles dealt out (roles.h). Nothing is guessed in
// silence: every guess stands in the text as a comment with its reason, and what was not found is asked for there and
// in `questions`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/recording.h"
#include "scenarios/robot.h"

namespace lacuna {

struct DraftRecording {
  std::string file;  ///< as the scenario will name it
  std::shared_ptr<const Recording> data;
  std::vector<RecordingPart> with = {};  ///< files joined to it, as the scenario will name them
};

struct DraftRequest {
  std::string name;
  std::string robot_file;  ///< as the scenario will name it
  std::shared_ptr<const Robot> robot;
  std::vector<DraftRecording> recordings;  ///< at least one
};

struct Draft {
  std::string yaml;                    ///< the commented scenario
  std::vector<std::string> guesses;    ///< what was guessed and why, a line each
  std::vector<std::string> questions;  ///< what only the user knows, a line each
  /// Where the clock is not in s: the column, and s per its unit. The text then names recordings by in_seconds(file),
  /// which the caller writes (a scenario's clock has no scale).
  std::string time_column;
  double time_scale = 1.0;
};

/// "runs/a.mat" -> "runs/a_in_s.csv".
std::string in_seconds(const std::string& file);

/// Throws InputError where there is nothing to go by: recordings of fewer than two samples, or a clock that does not
/// increase. The text parses as a scenario of format 1 whatever the columns are called.
Draft draft_scenario(const DraftRequest& request);

}  // namespace lacuna
