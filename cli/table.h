// A table for people, columns aligned, for standard output.
#pragma once

#include <string>
#include <vector>

namespace lacuna {

class TextTable {
 public:
  /// Columns whose title starts with '>' are set flush right (the mark is not printed).
  explicit TextTable(std::vector<std::string> titles);
  void add(std::vector<std::string> row);
  bool empty() const { return rows_.empty(); }
  std::string str() const;

 private:
  std::vector<std::string> titles_;
  std::vector<bool> right_;
  std::vector<std::vector<std::string>> rows_;
};

/// Words broken into lines of at most `width` characters, each after the first indented.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

}  // namespace lacuna
