// XML text, element by element, two spaces a level. Numbers stand in the shortest form that reads back to the same
// bits; -0 is 0.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <memory>
#include <string>

namespace lacuna {

class XmlWriter {
 public:
  XmlWriter();
  ~XmlWriter();

  /// `<?xml version="1.0"?>`.
  XmlWriter& declare();
  /// Begins an element on a line of its own.
  XmlWriter& open(const char* element);
  /// The same, and all that stands in it stays on its line.
  XmlWriter& line(const char* element);
  /// An attribute of the element begun last, which has no child yet.
  XmlWriter& set(const char* attribute, const std::string& text);
  XmlWriter& set(const char* attribute, std::initializer_list<double> numbers);
  XmlWriter& set(const char* attribute, double number) { return set(attribute, {number}); }
  XmlWriter& set(const char* attribute, const Eigen::Vector3d& v) { return set(attribute, {v.x(), v.y(), v.z()}); }
  /// Ends the element begun last that has not ended.
  XmlWriter& close();
  /// On a line of its own; two hyphens in a row, which a comment may not hold, are set apart.
  XmlWriter& comment(std::string text);

  std::string str() const;

 private:
  class Printer;
  std::unique_ptr<Printer> printer_;
  int on_a_line_ = 0;  ///< elements begun and not ended, from the innermost line() on
};

}  // namespace lacuna
