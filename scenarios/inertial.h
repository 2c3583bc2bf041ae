// What makes mass properties possible ones.
#pragma once

#include <string>

#include "scenarios/robot.h"

namespace lacuna {

/// Inertia tables are printed with about four significant digits, so each principal moment may be off by up to half a
/// unit in the fourth: 5e-4 of itself. A thin rod's moments then miss the triangle inequality by their roundings' sum.
inline constexpr double kRoundedTableSlack = 5e-4;

/// Throws InputError beginning with `where`: numbers not finite, a mass that is not positive, an inertia that is not
/// positive semidefinite or whose principal moments break the triangle inequality by more than rounded tables do.
void check_inertial(const Inertial& inertial, const std::string& where);

}  // namespace lacuna
