// Names of columns, joints and links as people write them, cut into words.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scenarios/robot.h"

namespace lacuna {

/// "shoulderPan_q2[deg]" -> shoulder, pan, q, 2, deg: runs of letters or digits, lower case, cut where a capital
/// follows a small letter. At most kMostWords.
std::vector<std::string> words_of(const std::string& name);
inline constexpr std::size_t kMostWords = 32;

/// For each joint the words that tell it from the others: those of its name without words that say nothing ("joint")
/// or that all joints share. Empty where nothing is left.
std::vector<std::set<std::string>> words_of_joints(const Robot& robot);
/// The same of the links that the joints move.
std::vector<std::set<std::string>> words_of_moved_links(const Robot& robot);

/// Words that stand beside a name without telling anything ("joint", "measured", "data").
bool says_nothing(const std::string& word);

}  // namespace lacuna
