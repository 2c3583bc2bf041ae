#include "draft/names.h"

#include <algorithm>
#include <cctype>

namespace lacuna {
namespace {

enum class Sort { none, small, capital, digit };

Sort sort_of(char c) {
  const auto byte = static_cast<unsigned char>(c);
  if (byte >= 0x80 || std::islower(byte) != 0) return Sort::small;  // UTF-8 beyond ASCII: letters to us
  if (std::isupper(byte) != 0) return Sort::capital;
  return std::isdigit(byte) != 0 ? Sort::digit : Sort::none;
}

/// Words of every name, less what says nothing and what all have in common.
std::vector<std::set<std::string>> telling_words(const std::vector<std::string>& names) {
  std::vector<std::set<std::string>> all, out;
  for (const std::string& name : names) {
    std::set<std::string> words;
    for (const std::string& word : words_of(name))
      if (!says_nothing(word)) words.insert(word);
    all.push_back(words);
  }
  for (const std::set<std::string>& words : all) {
    std::set<std::string> telling;
    for (const std::string& word : words) {
      const bool shared = all.size() > 1 &&
                          std::all_of(all.begin(), all.end(), [&](const auto& other) { return other.count(word) > 0; });
      if (!shared) telling.insert(word);
    }
    out.push_back(telling);
  }
  return out;
}

}  // namespace

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> out;
  Sort before = Sort::none;
  for (const char c : name) {
    const Sort sort = sort_of(c);
    const bool goes_on = sort == before || (before == Sort::capital && sort == Sort::small);
    if (sort != Sort::none && !(goes_on && !out.empty())) {
      if (out.size() == kMostWords) return out;
      out.emplace_back();
    }
    if (sort != Sort::none)
      out.back() += sort == Sort::capital ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : c;
    before = sort;
  }
  // "02" is 2 to whoever counts.
  for (std::string& word : out)
    if (std::isdigit(static_cast<unsigned char>(word.front())) != 0)
      word.erase(0, std::min(word.find_first_not_of('0'), word.size() - 1));
  return out;
}

bool says_nothing(const std::string& word) {
  static const std::set<std::string> kWords{"joint", "joints", "jnt",  "j",      "axis", "link",     "states",
                                            "state", "meas",   "data", "actual", "act",  "measured", "value",
                                            "msg",   "sensor", "the",  "of",     "raw",  "si"};
  return kWords.count(word) > 0;
}

std::vector<std::set<std::string>> words_of_joints(const Robot& robot) {
  std::vector<std::string> names;
  for (const Joint& joint : robot.joints()) names.push_back(joint.name);
  return telling_words(names);
}

std::vector<std::set<std::string>> words_of_moved_links(const Robot& robot) {
  std::vector<std::string> names;
  for (const Joint& joint : robot.joints()) names.push_back(robot.links()[joint.link].name);
  return telling_words(names);
}

}  // namespace lacuna
