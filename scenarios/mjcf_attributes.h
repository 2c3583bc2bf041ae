// Attributes of MJCF elements with their defaults: numbers, orientations, classes.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/xml_scan.h"

namespace lacuna {

/// The document's `compiler` and `default` sections, and how an element's attributes are read under them.
class MjcfAttributes {
 public:
  /// Throws InputError for settings that change the meaning of everything and are not understood.
  MjcfAttributes(const std::vector<XmlElement>& elements, std::string source);

  std::string where(int element) const;  ///< "file:line: <tag name>"
  [[noreturn]] void refuse(int element, const std::string& found, const std::string& expected) const;

  /// The attribute as written, or by the class of the element, of its bodies' `childclass`, of the main default.
  std::optional<std::string> text(int element, const std::string& attribute) const;
  /// Finite numbers; throws unless there are `least` to `most`.
  std::optional<std::vector<double>> numbers(int element, const std::string& attribute, std::size_t least,
                                             std::size_t most) const;
  double number(int element, const std::string& attribute, double otherwise) const;
  Eigen::Vector3d vector(int element, const std::string& attribute, const Eigen::Vector3d& otherwise) const;
  /// `pos` and whichever of quat, axisangle, euler, xyaxes, zaxis is given.
  Eigen::Isometry3d pose(int element) const;
  double angle(double written) const { return degrees_ ? written * kDegree : written; }  ///< rad

  bool inertia_from_geoms(bool has_inertial) const;

 private:
  static constexpr double kDegree = 0.017453292519943295;
  using Tags = std::map<std::string, std::map<std::string, std::string>>;

  void read_compiler(int element);
  void read_defaults(int element, const Tags& inherited, int depth);
  std::string class_of(int element) const;
  Eigen::Quaterniond orientation(int element) const;
  Eigen::Quaterniond euler(const std::vector<double>& angles) const;

  const std::vector<XmlElement>& elements_;
  std::string source_;
  bool degrees_ = true;
  std::string sequence_ = "xyz", from_geoms_ = "auto";
  std::map<std::string, Tags> classes_;
};

}  // namespace lacuna
