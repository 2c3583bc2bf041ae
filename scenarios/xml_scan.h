// A first look at XML before a library parses it: well-formed, shallow, and where every element stands.
//
// The library behind urdfdom recurses without a limit, keeps the last of two equal attributes and forgets the order
// of elements; messages need lines.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace lacuna {

struct XmlElement {
  std::string tag;
  std::vector<std::pair<std::string, std::string>> attributes;  ///< values with the five named entities undone
  int line = 0;                                                 ///< 1 is the first
  int parent = -1;                                              ///< index; -1 for the root

  const std::string* find(const std::string& attribute) const;
};

inline constexpr int kXmlMaxDepth = 64;
inline constexpr std::size_t kXmlMaxElements = 200'000;

/// Elements in the order written, the root first. Refuses DOCTYPE (entities could multiply), text that is no UTF-8,
/// tags that do not match, attributes given twice. Throws InputError with `source` and line.
std::vector<XmlElement> scan_xml(const std::string& text, const std::string& source);

}  // namespace lacuna
