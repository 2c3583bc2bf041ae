// YAML text for people to read: lists of numbers and short maps on one line, comments in a column. Numbers stand in the
// shortest form that reads back to the same bits, text in quotes wherever it could be read as anything else.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace lacuna {

class YamlWriter {
 public:
  /// Comments behind values begin at `comment_column`, or two spaces behind what goes beyond it.
  explicit YamlWriter(std::size_t comment_column = 0);
  ~YamlWriter();

  YamlWriter& key(const std::string& name);
  YamlWriter& value(const std::string& text);
  YamlWriter& value(double number);

  /// Maps and lists, as the document, a key's value or a list's item; the short ones stand on one line, with all that
  /// is in them.
  YamlWriter& map();
  YamlWriter& list();
  YamlWriter& short_map();
  YamlWriter& short_list();
  /// Ends the map or list begun last that has not ended.
  YamlWriter& end();

  template <class Value>
  YamlWriter& put(const std::string& name, const Value& one) {
    return key(name).value(one);
  }
  YamlWriter& put(const std::string& name, std::initializer_list<double> numbers);

  /// Behind what stands on the line.
  YamlWriter& comment(const std::string& text);
  /// Comments on lines of their own.
  YamlWriter& remark(const std::string& text);
  YamlWriter& blank_line();

  /// Without a line's end at its end.
  std::string str() const;

 private:
  class Emitter;
  std::size_t column() const;
  YamlWriter& begin(bool map, bool is_short);
  void end_line();

  std::unique_ptr<Emitter> emitter_;
  std::vector<bool> open_;  ///< whether it is a map
  std::size_t comment_column_;
  bool awaits_value_ = false;
};

}  // namespace lacuna
