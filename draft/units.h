// Units of the measured columns, from their names and, where these are silent, from their ranges.
#pragma once

#include <string>
#include <vector>

#include "scenarios/recording.h"
#include "scenarios/robot.h"
#include "draft/columns.h"

namespace lacuna {

/// value in SI = scale * column.
struct UnitGuess {
  double scale = 1.0;
  std::string text;  ///< "deg -> rad: a range of -90 to 120 leaves the joint's limits if it were rad"
  bool sure = true;  ///< said by the name, or nothing speaks against SI
};

/// Range of a column over all recordings.
struct ColumnRange {
  double low = 0.0, high = 0.0;
  bool any = false;  ///< whether a finite value was seen
  double largest() const;
};
ColumnRange range_of_column(const std::vector<const Recording*>& recordings, const std::string& column);

/// Of positions (velocities by the same factor where nothing better is known), efforts, pressures. `guesses` are all
/// columns: one logger writes all angles in one unit, so that a single joint beyond its limits decides for all.
UnitGuess guess_position_unit(const Robot& robot, const ColumnGuesses& guesses, const ColumnGuess& column,
                              const std::vector<const Recording*>& recordings);
UnitGuess guess_pressure_unit(const ColumnGuesses& guesses, const std::vector<const Recording*>& recordings,
                              const ColumnGuess& column);
UnitGuess guess_effort_unit(const Joint& joint, const ColumnGuess& column);

/// Of a speed by what the positions' differences say: `position` in SI, both on `time` (s).
UnitGuess guess_velocity_unit(const Joint& joint, const ColumnGuess& column, const std::vector<double>& time,
                              const std::vector<double>& position, const std::vector<double>& velocity);

}  // namespace lacuna
