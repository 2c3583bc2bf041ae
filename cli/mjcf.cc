#include "cli/mjcf.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "scenarios/text.h"

namespace lacuna {
namespace {

/// A comment may hold anything but two hyphens in a row.
std::string comment(const std::string& text) {
  std::string out = printable(text, 1000);
  for (std::size_t at = 0; (at = out.find("--", at)) != std::string::npos;) out.replace(at, 2, "- -");
  return "<!-- " + out + " -->\n";
}

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) {
    if (!out.empty()) out += ' ';
    out += format_number(value + 0.0);  // turns -0 into 0
  }
  return out;
}
std::string numbers(const Eigen::Vector3d& v) { return numbers({v.x(), v.y(), v.z()}); }

std::string placed(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond turn(pose.linear());
  return fmt::format("pos=\"{}\" quat=\"{}\"", numbers(pose.translation()),
                     numbers({turn.w(), turn.x(), turn.y(), turn.z()}));
}

/// MuJoCo refuses inertias on the edge of the triangle inequality (thin rods, point masses): these gain a billionth of
/// their size (a point mass 1e-9 kg m^2).
Eigen::Matrix3d acceptable(const Eigen::Matrix3d& inertia) {
  const Eigen::Vector3d e = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
  const double nudge = std::max(1e-9 * e[2], 1e-9);
  const bool inside = e[0] > 1e-12 && e[0] + e[1] - e[2] > 1e-10 * e[2];
  return inside ? inertia : Eigen::Matrix3d(inertia + nudge * Eigen::Matrix3d::Identity());
}

std::string inertial_text(const Inertial& inertial) {
  const Eigen::Matrix3d i = acceptable(inertial.inertia);
  return fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>\n", numbers(inertial.com),
                     format_number(inertial.mass), numbers({i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}));
}

std::string visual_text(const Visual& visual, const Eigen::Isometry3d& link_in_body) {
  const Eigen::Vector3d& s = visual.size;
  std::string shape;
  switch (visual.shape) {
    case Visual::Shape::box: shape = fmt::format("type=\"box\" size=\"{}\"", numbers(0.5 * s)); break;
    case Visual::Shape::cylinder:
      shape = fmt::format("type=\"cylinder\" size=\"{}\"", numbers({s[0], 0.5 * s[1]}));
      break;
    case Visual::Shape::sphere: shape = fmt::format("type=\"sphere\" size=\"{}\"", format_number(s[0])); break;
    case Visual::Shape::mesh: return "";  // left out before
  }
  return fmt::format("<geom class=\"visual\" {} {} rgba=\"{:.4g} {:.4g} {:.4g} {:.4g}\"/>\n", shape,
                     placed(link_in_body * visual.pose), visual.rgba[0], visual.rgba[1], visual.rgba[2],
                     visual.rgba[3]);
}

/// Parameters of one actuator or effect by their short names.
class Values {
 public:
  Values(const PlantModel& model, const Component& component, std::span<const double> values) {
    for (int k = 0; k < component.count; ++k) {
      const auto i = static_cast<std::size_t>(component.first) + static_cast<std::size_t>(k);
      of_[model.parameters()[i].key] = values[i];
      words_ += fmt::format("{}{} = {} {}", words_.empty() ? "" : ", ", model.parameters()[i].key,
                            format_number(values[i]), model.parameters()[i].unit);
    }
  }
  double operator[](const char* name) const {
    const auto at = of_.find(name);
    return at == of_.end() ? 0.0 : at->second;
  }
  bool has(const char* name) const { return of_.count(name) > 0; }
  const std::string& words() const { return words_; }

 private:
  std::map<std::string, double> of_;
  std::string words_;
};

class Writer {
 public:
  Writer(const PlantModel& model, std::span<const double> values)
      : model_(model),
        values_(values),
        robot_(model.robot()),
        inertials_(model.inertials(values)),
        armatures_(model.armatures(values)) {}

  std::string str() const {
    std::string out = fmt::format("<mujoco model=\"{}\">\n", xml_escaped(robot_.name()));
    out += "  <compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n";
    out += fmt::format("  <option gravity=\"{}\" integrator=\"implicit\"/>\n", numbers(model_.gravity(values_)));
    out +=
        "  <default><default class=\"visual\"><geom contype=\"0\" conaffinity=\"0\" group=\"1\" "
        "mass=\"0\"/></default></default>\n";
    for (const Component& effect : model_.effects()) out += "  " + effect_comment(effect);
    out += "  <worldbody>\n" + visuals(-1, "    ");
    for (int i = 0; i < robot_.dof(); ++i)
      if (joint(i).parent < 0) out += body(i, "    ");
    return out + "  </worldbody>\n  <actuator>\n" + actuators() + "  </actuator>\n</mujoco>\n";
  }

 private:
  const Joint& joint(int i) const { return robot_.joints()[static_cast<std::size_t>(i)]; }
  const Component& actuator(int i) const { return model_.actuators()[static_cast<std::size_t>(i)]; }
  std::string model_name(int i) const {
    return actuator(i).type < 0 ? "" : actuator_table()[static_cast<std::size_t>(actuator(i).type)].name;
  }

  std::string visuals(int carrier, const std::string& indent) const {
    std::string out;
    for (const Link& link : robot_.links()) {
      if (link.body != carrier) continue;
      for (const Visual& visual : link.visuals)
        if (visual.shape != Visual::Shape::mesh) out += indent + visual_text(visual, link.in_body);
    }
    return out;
  }

  std::string body(int i, const std::string& indent) const {
    const std::string& name = robot_.links()[static_cast<std::size_t>(joint(i).link)].name;
    std::string out = fmt::format("{}<body name=\"{}\" {}>\n", indent, xml_escaped(name), placed(joint(i).origin));
    const std::string inner = indent + "  ";
    out += inner + inertial_text(inertials_[static_cast<std::size_t>(i)]) + inner + joint_text(i) + visuals(i, inner);
    for (int child = i + 1; child < robot_.dof(); ++child)
      if (joint(child).parent == i) out += body(child, inner);
    return out + indent + "</body>\n";
  }

  /// Spring, damper and dry friction are the joint's; a flow source keeps its own in the actuator.
  std::string joint_text(int i) const {
    const Joint& j = joint(i);
    std::string out = fmt::format("<joint name=\"{}\" type=\"{}\" axis=\"{}\"", xml_escaped(j.name),
                                  j.prismatic() ? "slide" : "hinge", numbers(j.axis));
    if (std::isfinite(j.lower) && std::isfinite(j.upper))
      out += fmt::format(" limited=\"true\" range=\"{}\"", numbers({j.lower, j.upper}));
    if (actuator(i).type >= 0 && model_name(i) != "flow_source") {
      const Values p(model_, actuator(i), values_);
      if (p.has("damping")) out += fmt::format(" damping=\"{}\"", format_number(p["damping"]));
      if (p.has("stiffness"))
        out +=
            fmt::format(" stiffness=\"{}\" springref=\"{}\"", format_number(p["stiffness"]), format_number(p["rest"]));
    }
    const double friction = sum_over_effects(i, {"coulomb_friction", "stribeck_friction"}, "Fc");
    if (friction > 0.0) out += fmt::format(" frictionloss=\"{}\"", format_number(friction));
    const double armature = armatures_[static_cast<std::size_t>(i)];
    if (armature > 0.0) out += fmt::format(" armature=\"{}\"", format_number(armature));
    return out + "/>\n";
  }

  double sum_over_effects(int i, std::initializer_list<std::string_view> names, const char* parameter) const {
    double sum = 0.0;
    for (const Component& effect : model_.effects()) {
      const std::string_view name = effect_table()[static_cast<std::size_t>(effect.type)].name;
      if (effect.joint == i && std::find(names.begin(), names.end(), name) != names.end())
        sum += Values(model_, effect, values_)[parameter];
    }
    return sum;
  }

  /// The control is the recording's command, in its own unit.
  std::string actuators() const {
    std::string out;
    for (int i = 0; i < robot_.dof(); ++i) {
      if (actuator(i).type < 0) continue;
      const Values p(model_, actuator(i), values_);
      const std::string name = xml_escaped(joint(i).name);
      const double offset = sum_over_effects(i, {"valve_offset"}, "b");
      if (model_name(i) == "flow_source") {
        out += "    " + comment(joint(i).name + ": flow_source, " + p.words() +
                                "; its damper acts against the joint's speed alone, and the oil position starts at 0");
        out += fmt::format(
            "    <general name=\"{0}\" joint=\"{0}\" dyntype=\"integrator\" gainprm=\"{1}\" "
            "biastype=\"affine\" biasprm=\"{2}\"/>\n",
            name, format_number(p["stiffness"] * p["gain"]), numbers({0.0, -p["stiffness"], -p["damping"]}));
        continue;
      }
      if (actuator_table()[static_cast<std::size_t>(actuator(i).type)].chambers) {
        out += "    " + comment(joint(i).name + ": hydraulic, " + p.words() +
                                "; its chambers are not in this file: the control is the effort");
        out += fmt::format("    <motor name=\"{0}\" joint=\"{0}\"/>\n", name);
        continue;
      }
      out += fmt::format(
          "    <general name=\"{0}\" joint=\"{0}\" gainprm=\"{1}\" biastype=\"affine\" biasprm=\"{2} 0 0\"{3}/>\n",
          name, format_number(p["gain"]), format_number(p["gain"] * offset), valve_attributes(i));
    }
    return out;
  }

  /// A lag is MuJoCo's filter; a saturation the control's range, where it is hard.
  std::string valve_attributes(int i) const {
    std::string out;
    const double lag = sum_over_effects(i, {"actuator_lag"}, "T");
    if (lag > 0.0) out += fmt::format(" dyntype=\"filter\" dynprm=\"{}\"", format_number(lag));
    const double cap = sum_over_effects(i, {"actuator_saturation"}, "cap");
    if (cap > 0.0 && std::isfinite(cap))
      out += fmt::format(" ctrllimited=\"true\" ctrlrange=\"{}\"", numbers({-cap, cap}));
    return out;
  }

  std::string effect_comment(const Component& effect) const {
    const EffectInfo& info = effect_table()[static_cast<std::size_t>(effect.type)];
    const std::string name = info.name;
    static const std::map<std::string, const char*> kept = {
        {"coulomb_friction", "as frictionloss"},
        {"stribeck_friction", "Fc as frictionloss, the rest not in this file"},
        {"payload", "in the inertia of the body that carries it"},
        {"com_shift", "in the inertial of its body"},
        {"rigid_body", "in the inertial of its body"},
        {"armature", "as armature"},
        {"base_tilt", "in the direction of gravity"}};
    static const std::map<std::string, const char*> kept_by_the_valve = {
        {"valve_offset", "in the actuator's bias"},
        {"actuator_lag", "as the actuator's filter"},
        {"actuator_saturation", "as the control's range, without its soft edge"}};
    std::string held = "not in this file";
    if (const auto at = kept.find(name); at != kept.end()) held = at->second;
    const auto at = kept_by_the_valve.find(name);
    if (at != kept_by_the_valve.end() && model_name(effect.joint) != "flow_source") held = at->second;
    std::string text = fmt::format("{} at {}: {}, {}; {}", name, model_.place_name(effect), info.equation,
                                   Values(model_, effect, values_).words(), held);
    if (!effect.recordings.empty()) text += "; acts in some recordings only";
    return comment(text);
  }

  const PlantModel& model_;
  std::span<const double> values_;
  const Robot& robot_;
  std::vector<Inertial> inertials_;
  std::vector<double> armatures_;  ///< kg m^2 or kg, per joint
};

}  // namespace

std::string to_mjcf(const PlantModel& model, std::span<const double> values) { return Writer(model, values).str(); }

std::string plant_in_words(const PlantModel& model, std::span<const double> values) {
  std::string out;
  for (const Component& actuator : model.actuators()) {
    if (actuator.type < 0) continue;
    const ActuatorInfo& info = actuator_table()[static_cast<std::size_t>(actuator.type)];
    out += comment(fmt::format("{} at {}: {}, {}", info.name, model.place_name(actuator), info.equation,
                               Values(model, actuator, values).words()));
  }
  for (const Component& effect : model.effects()) {
    const EffectInfo& info = effect_table()[static_cast<std::size_t>(effect.type)];
    out += comment(fmt::format("{} at {}: {}, {}", info.name, model.place_name(effect), info.equation,
                               Values(model, effect, values).words()));
  }
  return out;
}

}  // namespace lacuna
