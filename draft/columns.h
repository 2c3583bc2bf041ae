// Which column of a recording is which quantity of which joint, by names alone. What the numbers say comes after
// (draft/units.h).
#pragma once

#include <string>
#include <vector>

#include "scenarios/robot.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// A column that was understood.
struct ColumnGuess {
  std::string column;
  ChannelKind kind = ChannelKind::position;
  int joint = -1;
  bool current = false;    ///< of the motor, A: an effort by way of the drive's gain
  bool is_effort = false;  ///< of a command: its name says that it is a torque or force
  std::string unit;        ///< as the name says it ("deg", "bar"); empty: it does not
  std::string reason;      ///< how the joint was found
  bool sure = true;        ///< the names agree; else it is a guess worth a look
};

struct UnusedColumn {
  std::string column;
  std::string reason;
  bool asks = false;  ///< it may well matter: the user is asked
};

struct ColumnGuesses {
  std::string time;                  ///< empty: no column is named like a time
  std::string time_unit;             ///< as the name says it; empty: it does not
  std::vector<ColumnGuess> columns;  ///< at most one for each kind and joint, in the order of the file
  std::vector<UnusedColumn> unused;

  const ColumnGuess* find(ChannelKind kind, int joint) const;
};

/// What the columns are for, as a scenario with these channels would use them.
ColumnUse use_of(const ColumnGuesses& guesses);

/// Names of a recording's columns against the robot's. Never throws for any names.
ColumnGuesses match_columns(const Robot& robot, const std::vector<std::string>& names);

}  // namespace lacuna
