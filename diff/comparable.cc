#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenarios/error.h"
#include "diff/diff.h"

namespace lacuna {
namespace {

constexpr double kSameNumber = 1e-9;  ///< relative: two numbers written alike

bool same(double x, double y) {
  return x == y || std::fabs(x - y) <= kSameNumber * std::max(std::fabs(x), std::fabs(y));
}

/// Two entries of one kind, compared by key and value.
class Compared {
 public:
  Compared(const Scenario& a, const Scenario& b) : b_(b.file.string()), a_(a.file.string()) {}

  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& expected) const {
    throw InputError(b_ + ": " + key, found, expected + ", as in " + a_);
  }
  void number(const std::string& key, double a, double b) const {
    if (!same(a, b)) refuse(key, fmt::format("{:.10g}", b), fmt::format("{:.10g}", a));
  }
  void text(const std::string& key, const std::string& a, const std::string& b) const {
    if (a != b) refuse(key, b.empty() ? "none" : quoted(b), a.empty() ? "none" : quoted(a));
  }
  void numbers(const std::string& key, const std::map<std::string, double>& a,
               const std::map<std::string, double>& b) const {
    for (const auto& [name, value] : a) {
      const auto at = b.find(name);
      if (at == b.end()) refuse(key + "." + name, "none", fmt::format("{:.10g}", value));
      number(key + "." + name, value, at->second);
    }
    for (const auto& [name, value] : b)
      if (!a.contains(name)) refuse(key + "." + name, fmt::format("{:.10g}", value), "none");
  }

 private:
  std::string b_, a_;
};

std::string names_of(const Robot& robot) {
  std::string out;
  for (const Joint& joint : robot.joints()) out += (out.empty() ? "" : ", ") + joint.name;
  return out;
}

void compare_robots(const Compared& compared, const Scenario& a, const Scenario& b) {
  compared.text("robot", names_of(*a.robot), names_of(*b.robot));
  for (std::size_t i = 0; i < std::min(a.robot->links().size(), b.robot->links().size()); ++i) {
    const Link &x = a.robot->links()[i], &y = b.robot->links()[i];
    compared.text("robot", x.name, y.name);
    compared.number("robot: mass of " + x.name, x.inertial.mass, y.inertial.mass);
  }
  if (to_urdf(*a.robot) != to_urdf(*b.robot))
    compared.refuse("robot", quoted(b.robot_file) + " with other frames or inertias", "the same robot");
  for (int i = 0; i < 3; ++i) compared.number("gravity", a.gravity(i), b.gravity(i));
  compared.number("total_mass", a.total_mass.value_or(0.0), b.total_mass.value_or(0.0));
}

void compare_actuators(const Compared& compared, const Scenario& a, const Scenario& b) {
  const auto of = [](const Scenario& s, const std::string& joint) -> const ActuatorSpec* {
    const auto at =
        std::find_if(s.actuators.begin(), s.actuators.end(), [&](const auto& x) { return x.joint == joint; });
    return at == s.actuators.end() ? nullptr : &*at;
  };
  for (const Joint& joint : a.robot->joints()) {
    const ActuatorSpec *x = of(a, joint.name), *y = of(b, joint.name);
    const std::string key = "actuators." + joint.name;
    compared.text(key + ".model", x != nullptr ? x->model : "", y != nullptr ? y->model : "");
    if (x != nullptr) compared.numbers(key, x->parameters, y->parameters);
  }
}

void compare_identify(const Compared& compared, const Scenario& a, const Scenario& b) {
  const auto words = [](const Scenario& s) {
    std::vector<std::string> out;
    for (const IdentifySpec& i : s.identify)
      out.push_back(fmt::format("{}: {} [{:.10g}, {:.10g}]", i.name, i.relative ? "relative_bounds" : "bounds", i.lower,
                                i.upper));
    return out;
  };
  const auto x = words(a), y = words(b);
  for (std::size_t i = 0; i < std::max(x.size(), y.size()); ++i)
    compared.text("identify", i < x.size() ? x[i] : "", i < y.size() ? y[i] : "");
}

void compare_channels(const Compared& compared, const Scenario& a, const Scenario& b) {
  const auto words = [](const Scenario& s, ChannelKind kind, const std::string& joint) -> std::string {
    const auto of = s.channels.of.find(kind);
    if (of == s.channels.of.end() || !of->second.contains(joint)) return "";
    const ColumnSpec& c = of->second.at(joint);
    std::string out = fmt::format("scale {:.10g}, offset {:.10g}", c.scale, c.offset);
    return c.unit.empty() ? out : out + ", unit " + c.unit;
  };
  for (const ChannelKind kind :
       {ChannelKind::command, ChannelKind::position, ChannelKind::velocity, ChannelKind::effort,
        ChannelKind::motor_position, ChannelKind::pressure_a, ChannelKind::pressure_b}) {
    for (const Joint& joint : a.robot->joints())
      compared.text(fmt::format("channels.{}.{}", to_string(kind), joint.name), words(a, kind, joint.name),
                    words(b, kind, joint.name));
  }
}

void compare_effects(const Compared& compared, const Scenario& a, const Scenario& b) {
  const auto names = [](const Scenario& s) {
    std::vector<std::string> out;
    for (const EffectSpec& e : s.effects) out.push_back(e.effect + " at " + e.place);
    return out;
  };
  const auto x = names(a), y = names(b);
  for (std::size_t i = 0; i < std::max(x.size(), y.size()); ++i)
    compared.text("effects", i < x.size() ? x[i] : "", i < y.size() ? y[i] : "");
  for (std::size_t i = 0; i < x.size(); ++i)
    compared.numbers("effects." + x[i], a.effects[i].parameters, b.effects[i].parameters);
}

std::string words_of(const Scenario& scenario) {
  std::string out = "free_run";
  if (const auto* w = std::get_if<Windows>(&scenario.prediction)) out = fmt::format("{{horizon: {:.10g}}}", w->horizon);
  if (const auto* i = std::get_if<InverseDynamics>(&scenario.prediction))
    out = fmt::format("{{inverse_dynamics: {{cutoff_hz: {:.10g}}}}}", i->cutoff_hz);
  return scenario.pressure_driven ? "{pressure_driven: " + out + "}" : out;
}

}  // namespace

void check_comparable(const Scenario& a, const Scenario& b) {
  const Compared compared(a, b);
  compare_robots(compared, a, b);
  compare_actuators(compared, a, b);
  compare_effects(compared, a, b);
  compare_identify(compared, a, b);
  compare_channels(compared, a, b);
  compared.text("prediction", words_of(a), words_of(b));
}

}  // namespace lacuna
