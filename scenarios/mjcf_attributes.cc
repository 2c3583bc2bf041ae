#include "scenarios/mjcf_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

/// Elements whose attributes are read. Every class holds a copy of all that it inherits, hence the bounds.
const std::set<std::string> kWithDefaults{"joint", "geom", "motor", "general", "position", "velocity"};
constexpr std::size_t kMostClasses = 500, kMostDefaults = 64, kLongestDefault = 200;

}  // namespace

MjcfAttributes::MjcfAttributes(const std::vector<XmlElement>& elements, std::string source)
    : elements_(elements), source_(std::move(source)) {
  for (int i = 1; i < std::ssize(elements_); ++i) {
    const XmlElement& element = elements_[i];
    if (element.tag == "include") refuse(i, "an include", "everything in one file: no other is opened");
    if (element.parent != 0) continue;
    if (element.tag == "compiler") read_compiler(i);
    if (element.tag == "default") read_defaults(i, {}, 0);
  }
}

std::string MjcfAttributes::where(int element) const {
  const XmlElement& at = elements_[element];
  const std::string* name = at.find("name");
  return fmt::format("{}:{}: {}{}", printable(source_), at.line, printable(at.tag, 40),
                     name != nullptr ? " " + printable(*name, 60) : "");
}

void MjcfAttributes::refuse(int element, const std::string& found, const std::string& expected) const {
  throw InputError(where(element), found, expected);
}

void MjcfAttributes::read_compiler(int element) {
  const XmlElement& compiler = elements_[element];
  for (const auto& [key, value] : compiler.attributes) {
    if (key == "angle") {
      if (value != "degree" && value != "radian") refuse(element, "angle " + quoted(value), "degree or radian");
      degrees_ = value == "degree";
    } else if (key == "eulerseq") {
      sequence_ = value;
      const bool known = value.size() == 3 && value.find_first_not_of("xyzXYZ") == std::string::npos;
      if (!known) refuse(element, "eulerseq " + quoted(value), "three letters of xyzXYZ");
    } else if (key == "inertiafromgeom") {
      from_geoms_ = value;
      if (value != "true" && value != "false" && value != "auto")
        refuse(element, "inertiafromgeom " + quoted(value), "true, false or auto");
    } else if ((key == "coordinate" && value == "global") || (key == "balanceinertia" && value == "true") ||
               key == "boundmass" || key == "boundinertia" || key == "settotalmass" || key == "inertiagrouprange") {
      refuse(element, key + " " + quoted(value), "a file without this setting: it changes masses or places");
    }
  }
}

void MjcfAttributes::read_defaults(int element, const Tags& inherited, int depth) {
  const XmlElement& section = elements_[element];
  const std::string* name = section.find("class");
  if (depth > 0 && name == nullptr) refuse(element, "a default without class", "class=\"...\"");
  const std::string key = name != nullptr ? *name : "main";
  // Each class holds all that it inherits.
  if (classes_.size() > kMostClasses) refuse(element, "one class more", fmt::format("at most {}", kMostClasses));
  Tags tags = inherited;
  for (int i = element + 1; i < std::ssize(elements_); ++i) {
    const XmlElement& child = elements_[i];
    if (child.parent != element || child.tag == "default") continue;
    if (kWithDefaults.count(child.tag) == 0) continue;
    for (const auto& [attribute, value] : child.attributes) {
      if (value.size() > kLongestDefault)
        refuse(i, fmt::format("a default of {} bytes", value.size()), fmt::format("at most {}", kLongestDefault));
      tags[child.tag][attribute] = value;
      if (tags[child.tag].size() > kMostDefaults)
        refuse(i, "one default more", fmt::format("at most {}", kMostDefaults));
    }
  }
  if (!classes_.emplace(depth == 0 ? "main" : key, tags).second)
    refuse(element, "the class " + quoted(key) + " twice", "it once");
  if (depth == 0 && key != "main") classes_.emplace(key, tags);
  for (int i = element + 1; i < std::ssize(elements_); ++i) {
    const XmlElement& child = elements_[i];
    if (child.parent == element && child.tag == "default") read_defaults(i, tags, depth + 1);
  }
}

std::string MjcfAttributes::class_of(int element) const {
  const XmlElement& at = elements_[element];
  if (const std::string* own = at.find("class")) return *own;
  for (int up = at.parent; up >= 0; up = elements_[up].parent)
    if (const std::string* children = elements_[up].find("childclass")) return *children;
  return "main";
}

std::optional<std::string> MjcfAttributes::text(int element, const std::string& attribute) const {
  const XmlElement& at = elements_[element];
  if (const std::string* own = at.find(attribute)) return *own;
  const std::string name = class_of(element);
  const auto tags = classes_.find(name);
  if (tags == classes_.end()) {
    if (name != "main") refuse(element, "the class " + quoted(name), "a class of the default section");
    return std::nullopt;
  }
  const auto tag = tags->second.find(at.tag);
  if (tag == tags->second.end()) return std::nullopt;
  const auto value = tag->second.find(attribute);
  return value == tag->second.end() ? std::nullopt : std::optional(value->second);
}

std::optional<std::vector<double>> MjcfAttributes::numbers(int element, const std::string& attribute, std::size_t least,
                                                           std::size_t most) const {
  const auto written = text(element, attribute);
  if (!written) return std::nullopt;
  const auto fail = [&] {
    refuse(element, attribute + "=" + quoted(*written),
           least == most ? fmt::format("{} finite number{}", least, least == 1 ? "" : "s")
                         : fmt::format("{} to {} finite numbers", least, most));
  };
  std::vector<double> out;
  for (std::size_t begin = 0; (begin = written->find_first_not_of(" \t\n\r", begin)) != std::string::npos;) {
    const std::size_t end = std::min(written->find_first_of(" \t\n\r", begin), written->size());
    const auto value = parse_number(written->substr(begin, end - begin));
    if (!value || !std::isfinite(*value) || out.size() == most) fail();
    out.push_back(*value);
    begin = end;
  }
  if (out.size() < least) fail();
  return out;
}

double MjcfAttributes::number(int element, const std::string& attribute, double otherwise) const {
  const auto value = numbers(element, attribute, 1, 1);
  return value ? value->front() : otherwise;
}

Eigen::Vector3d MjcfAttributes::vector(int element, const std::string& attribute,
                                       const Eigen::Vector3d& otherwise) const {
  const auto value = numbers(element, attribute, 3, 3);
  return value ? Eigen::Vector3d(value->data()) : otherwise;
}

Eigen::Quaterniond MjcfAttributes::euler(const std::vector<double>& angles) const {
  Eigen::Quaterniond out = Eigen::Quaterniond::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const char letter = sequence_[i];
    const bool fixed = letter < 'a';  // capital: about the parent's axes
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(fixed ? letter - 'X' : letter - 'x');
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle(angles[i]), axis));
    out = fixed ? turn * out : out * turn;
  }
  return out;
}

Eigen::Quaterniond MjcfAttributes::orientation(int element) const {
  const auto axis_of = [&](const std::vector<double>& x, std::size_t from) {
    const Eigen::Vector3d axis(x[from], x[from + 1], x[from + 2]);
    if (!(axis.norm() > 1e-9) || !std::isfinite(axis.norm()))
      refuse(element, "an orientation without direction", "an axis that is not 0");
    return Eigen::Vector3d(axis.normalized());
  };
  if (const auto q = numbers(element, "quat", 4, 4)) {
    const Eigen::Quaterniond out((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
    if (!(out.norm() > 1e-9) || !std::isfinite(out.norm()))
      refuse(element, "a quaternion of length 0", "w x y z, not all 0");
    return out.normalized();
  }
  if (const auto a = numbers(element, "axisangle", 4, 4))
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle((*a)[3]), axis_of(*a, 0)));
  if (const auto e = numbers(element, "euler", 3, 3)) return euler(*e);
  if (const auto xy = numbers(element, "xyaxes", 6, 6)) {
    Eigen::Matrix3d out;
    out.col(0) = axis_of(*xy, 0);
    const Eigen::Vector3d y = axis_of(*xy, 3), flat = y - y.dot(out.col(0)) * out.col(0);
    if (!(flat.norm() > 1e-6)) refuse(element, "xyaxes along one line", "two directions");
    out.col(1) = flat.normalized(), out.col(2) = out.col(0).cross(out.col(1));
    return Eigen::Quaterniond(out);
  }
  if (const auto z = numbers(element, "zaxis", 3, 3))
    return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis_of(*z, 0));
  return Eigen::Quaterniond::Identity();
}

Eigen::Isometry3d MjcfAttributes::pose(int element) const {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.translation() = vector(element, "pos", Eigen::Vector3d::Zero());
  out.linear() = orientation(element).toRotationMatrix();
  return out;
}

bool MjcfAttributes::inertia_from_geoms(bool has_inertial) const {
  return from_geoms_ == "true" || (from_geoms_ == "auto" && !has_inertial);
}

}  // namespace lacuna
