#include "scenarios/urdf_outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::size_t kMaxLinks = 1000;
const std::vector<std::string> kJointTypes{"revolute", "continuous", "prismatic", "fixed"};

/// Which attributes hold numbers, and how many.
struct NumberRule {
  const char* tag;
  const char* attribute;
  int count;
};
constexpr NumberRule kNumberRules[] = {
    {"origin", "xyz", 3},      {"origin", "rpy", 3},    {"axis", "xyz", 3},       {"mass", "value", 1},
    {"inertia", "ixx", 1},     {"inertia", "ixy", 1},   {"inertia", "ixz", 1},    {"inertia", "iyy", 1},
    {"inertia", "iyz", 1},     {"inertia", "izz", 1},   {"box", "size", 3},       {"cylinder", "radius", 1},
    {"cylinder", "length", 1}, {"sphere", "radius", 1}, {"color", "rgba", 4},     {"limit", "lower", 1},
    {"limit", "upper", 1},     {"limit", "effort", 1},  {"limit", "velocity", 1}, {"mesh", "scale", 3}};

/// Attributes without which an element means nothing; urdfdom fills some of them in silently.
constexpr std::pair<const char*, const char*> kRequired[] = {
    {"mass", "value"},  {"inertia", "ixx"}, {"inertia", "ixy"},  {"inertia", "ixz"},   {"inertia", "iyy"},
    {"inertia", "iyz"}, {"inertia", "izz"}, {"limit", "effort"}, {"limit", "velocity"}};

class Outliner {
 public:
  Outliner(const std::vector<XmlElement>& elements, const std::string& source)
      : elements_(elements), source_(printable(source)) {}

  UrdfOutline run() {
    if (elements_.front().tag != "robot") refuse(elements_.front(), "<" + tag(elements_.front()) + ">", "<robot>");
    for (const XmlElement& element : elements_) check_numbers(element);
    for (std::size_t i = 0; i < elements_.size(); ++i)
      if (elements_[i].parent == 0 && elements_[i].tag == "link") add_link(i);
    if (out_.links.empty()) refuse(elements_.front(), "no <link>", "a robot with links");
    for (std::size_t i = 0; i < elements_.size(); ++i)
      if (elements_[i].parent == 0 && elements_[i].tag == "joint") add_joint(i);
    find_root();
    sort_joints();
    return std::move(out_);
  }

 private:
  static std::string tag(const XmlElement& element) { return printable(element.tag, 40); }
  std::string place(const XmlElement& element) const { return fmt::format("{}:{}", source_, element.line); }
  [[noreturn]] void refuse(const XmlElement& element, const std::string& found, const std::string& expected) const {
    throw InputError(place(element), found, expected);
  }

  /// Whether the element belongs to the robot's links and joints, not to an extension (transmission, gazebo, ...).
  bool is_ours(const XmlElement& element) const {
    int at = static_cast<int>(&element - elements_.data());
    while (at > 0 && elements_[at].parent > 0) at = elements_[at].parent;
    const std::string& top = elements_[at].tag;
    return top == "link" || top == "joint" || top == "material";
  }

  void check_numbers(const XmlElement& element) const {
    if (!is_ours(element)) return;
    for (const auto& [required_tag, attribute] : kRequired)
      if (element.tag == required_tag && element.find(attribute) == nullptr)
        refuse(element, fmt::format("<{}> without {}", required_tag, attribute), "all its attributes");
    for (const NumberRule& rule : kNumberRules) {
      const std::string* text = element.tag == rule.tag ? element.find(rule.attribute) : nullptr;
      if (text == nullptr) continue;
      const std::string where = fmt::format("{}: <{}> {}", place(element), rule.tag, rule.attribute);
      const std::string expected = rule.count == 1 ? "a finite number" : fmt::format("{} finite numbers", rule.count);
      std::istringstream words(*text);
      std::string word;
      int count = 0;
      while (words >> word) {
        const auto number = parse_number(word);
        if (!number || !std::isfinite(*number)) throw InputError(where, quoted(*text), expected);
        ++count;
      }
      if (count != rule.count) throw InputError(where, quoted(*text), expected);
    }
  }

  const XmlElement* only_child(std::size_t parent, const char* name) const {
    const XmlElement* found = nullptr;
    for (std::size_t i = parent + 1; i < elements_.size() && elements_[i].parent >= static_cast<int>(parent); ++i) {
      if (elements_[i].parent != static_cast<int>(parent) || elements_[i].tag != name) continue;
      if (found != nullptr) refuse(elements_[i], fmt::format("a second <{}>", name), "one");
      found = &elements_[i];
    }
    return found;
  }

  std::string name_of(const XmlElement& element) const {
    const std::string* name = element.find("name");
    if (name == nullptr || name->empty()) refuse(element, "<" + tag(element) + "> without a name", "a name");
    return *name;
  }

  void add_link(std::size_t index) {
    const XmlElement& element = elements_[index];
    const std::string name = name_of(element);
    if (out_.links.size() == kMaxLinks) refuse(element, fmt::format("more than {} links", kMaxLinks), "fewer");
    if (!link_index_.emplace(name, static_cast<int>(out_.links.size())).second)
      refuse(element, "the link " + quoted(name) + " twice", "unique names");
    out_.links.push_back({name, place(element) + ": link " + printable(name, 60), -1});
    if (only_child(index, "inertial") == nullptr) return;
    const std::size_t inertial = only_child(index, "inertial") - elements_.data();
    for (const char* part : {"mass", "inertia"})
      if (only_child(inertial, part) == nullptr)
        refuse(elements_[inertial], fmt::format("<inertial> without <{}>", part), "mass and inertia");
  }

  int link_of(std::size_t joint, const char* end, const std::string& where) const {
    const XmlElement* element = only_child(joint, end);
    const std::string* name = element == nullptr ? nullptr : element->find("link");
    if (name == nullptr) throw InputError(where, fmt::format("no <{} link='...'/>", end), "a parent and a child link");
    const auto found = link_index_.find(*name);
    if (found == link_index_.end()) {
      std::vector<std::string> names;
      for (const auto& link : out_.links) names.push_back(link.name);
      throw InputError(where + ": " + end, "the link " + quoted(*name) + ", which does not exist", one_of(names));
    }
    return found->second;
  }

  void add_joint(std::size_t index) {
    const XmlElement& element = elements_[index];
    UrdfOutline::JointEntry joint;
    joint.name = name_of(element);
    joint.where = place(element) + ": joint " + printable(joint.name, 60);
    const std::string* type = element.find("type");
    if (type == nullptr || std::find(kJointTypes.begin(), kJointTypes.end(), *type) == kJointTypes.end())
      throw InputError(joint.where + ": type", type == nullptr ? "none" : quoted(*type, 40), one_of(kJointTypes));
    joint.type = *type;
    for (const auto& other : out_.joints)
      if (other.name == joint.name) refuse(element, "the joint " + quoted(joint.name) + " twice", "unique names");
    joint.parent = link_of(index, "parent", joint.where);
    joint.child = link_of(index, "child", joint.where);
    if ((joint.type == "revolute" || joint.type == "prismatic") && only_child(index, "limit") == nullptr)
      throw InputError(joint.where, "no <limit>", "one, as URDF asks for " + joint.type + " joints");
    only_child(index, "origin");
    only_child(index, "axis");
    auto& child = out_.links[joint.child];
    if (child.joint >= 0)
      throw InputError(joint.where,
                       "the link " + quoted(child.name) + " as the child of a second joint (first of " +
                           quoted(out_.joints[child.joint].name) + ")",
                       "a tree");
    child.joint = static_cast<int>(out_.joints.size());
    out_.joints.push_back(std::move(joint));
  }

  void find_root() {
    for (std::size_t i = 0; i < out_.links.size(); ++i) {
      if (out_.links[i].joint >= 0) continue;
      if (out_.root >= 0)
        throw InputError(out_.links[i].where,
                         "a second link without a parent (the first is " + quoted(out_.links[out_.root].name) + ")",
                         "a tree with one root");
      out_.root = static_cast<int>(i);
    }
    if (out_.root < 0) refuse(elements_.front(), "no link without a parent (the joints form a cycle)", "one root");
  }

  /// Parents before children; joints that already stand so keep their order.
  void sort_joints() {
    std::vector<UrdfOutline::JointEntry> sorted;
    std::vector<bool> placed(out_.links.size(), false), taken(out_.joints.size(), false);
    placed[out_.root] = true;
    bool progress = true;
    while (progress) {
      progress = false;
      for (std::size_t i = 0; i < out_.joints.size(); ++i) {
        const auto& joint = out_.joints[i];
        if (taken[i] || !placed[joint.parent]) continue;
        taken[i] = placed[joint.child] = progress = true;
        out_.links[joint.child].joint = static_cast<int>(sorted.size());
        sorted.push_back(joint);
      }
    }
    for (std::size_t i = 0; i < out_.joints.size(); ++i)
      if (!taken[i])
        throw InputError(out_.joints[i].where, "a cycle of joints apart from the root", "a tree with one root");
    out_.joints = std::move(sorted);
  }

  const std::vector<XmlElement>& elements_;
  std::string source_;
  std::map<std::string, int> link_index_;
  UrdfOutline out_;
};

}  // namespace

UrdfOutline outline_urdf(const std::vector<XmlElement>& elements, const std::string& source) {
  return Outliner(elements, source).run();
}

}  // namespace lacuna
