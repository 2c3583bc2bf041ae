// A set of recordings named on the command line, read with another scenario's channels and model.
#pragma once

#include <string>

#include "scenarios/scenario.h"

namespace lacuna {

/// `scenario` with the recordings of `set` in place of its own: a folder (its .csv, .mat, .db3 and .mcap files and
/// bags, by name), one such file, a .txt file with one path a line (relative to it), or several of these with commas.
/// Of three or more the last is `test`, the one before it `validate`, the others `train`; of two the first is `train`
/// and the other is halved into `validate` and `test`; a lone one is cut at 60 and 80 % of its time into `train`,
/// `validate` and `test`. `argument` names it in messages ("A"). Throws InputError.
Scenario with_recording_set(const Scenario& scenario, const std::string& set, const std::string& argument);

}  // namespace lacuna
