#include "cli/mjcf.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "scenarios/text.h"
#include "scenarios/xml_writer.h"

namespace lacuna {
namespace {

void put_comment(XmlWriter& xml, const std::string& text) { xml.comment(printable(text, 1000)); }

void put_pose(XmlWriter& xml, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond turn(pose.linear());
  xml.set("pos", pose.translation()).set("quat", {turn.w(), turn.x(), turn.y(), turn.z()});
}

/// MuJoCo refuses inertias on the edge of the triangle inequality (thin rods, point masses): these gain a billionth of
/// their size (a point mass 1e-9 kg m^2).
Eigen::Matrix3d acceptable(const Eigen::Matrix3d& inertia) {
  const Eigen::Vector3d e = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
  const double nudge = std::max(1e-9 * e[2], 1e-9);
  const bool inside = e[0] > 1e-12 && e[0] + e[1] - e[2] > 1e-10 * e[2];
  return inside ? inertia : Eigen::Matrix3d(inertia + nudge * Eigen::Matrix3d::Identity());
}

void put_inertial(XmlWriter& xml, const Inertial& inertial) {
  const Eigen::Matrix3d i = acceptable(inertial.inertia);
  xml.open("inertial").set("pos", inertial.com).set("mass", inertial.mass);
  xml.set("fullinertia", {i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}).close();
}

/// Meshes are left out.
void put_visual(XmlWriter& xml, const Visual& visual, const Eigen::Isometry3d& link_in_body) {
  if (visual.shape == Visual::Shape::mesh) return;
  const Eigen::Vector3d& s = visual.size;
  xml.open("geom").set("class", "visual");
  switch (visual.shape) {
    case Visual::Shape::box: xml.set("type", "box").set("size", 0.5 * s); break;
    case Visual::Shape::cylinder: xml.set("type", "cylinder").set("size", {s[0], 0.5 * s[1]}); break;
    case Visual::Shape::sphere: xml.set("type", "sphere").set("size", s[0]); break;
    case Visual::Shape::mesh: break;
  }
  put_pose(xml, link_in_body * visual.pose);
  xml.set("rgba", fmt::format("{:.4g}", fmt::join(visual.rgba, " "))).close();
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

  std::string str() {
    xml_.open("mujoco").set("model", robot_.name());
    xml_.open("compiler").set("angle", "radian").set("inertiafromgeom", "false").close();
    xml_.open("option").set("gravity", model_.gravity(values_)).set("integrator", "implicit").close();
    xml_.line("default").open("default").set("class", "visual");
    xml_.open("geom").set("contype", 0.0).set("conaffinity", 0.0).set("group", 1.0).set("mass", 0.0);
    xml_.close().close().close();
    for (const Component& effect : model_.effects()) put_comment(xml_, in_words(effect));
    xml_.open("worldbody");
    put_visuals(-1);
    for (int i = 0; i < robot_.dof(); ++i)
      if (joint(i).parent < 0) put_body(i);
    xml_.close().open("actuator");
    for (int i = 0; i < robot_.dof(); ++i)
      if (actuator(i).type >= 0) put_actuator(i);
    return xml_.close().close().str();
  }

 private:
  const Joint& joint(int i) const { return robot_.joints()[i]; }
  const Component& actuator(int i) const { return model_.actuators()[i]; }
  std::string model_name(int i) const { return actuator(i).type < 0 ? "" : actuator_table()[actuator(i).type].name; }

  void put_visuals(int carrier) {
    for (const Link& link : robot_.links()) {
      if (link.body != carrier) continue;
      for (const Visual& visual : link.visuals) put_visual(xml_, visual, link.in_body);
    }
  }

  void put_body(int i) {
    xml_.open("body").set("name", robot_.links()[joint(i).link].name);
    put_pose(xml_, joint(i).origin);
    put_inertial(xml_, inertials_[i]);
    put_joint(i);
    put_visuals(i);
    for (int child = i + 1; child < robot_.dof(); ++child)
      if (joint(child).parent == i) put_body(child);
    xml_.close();
  }

  /// Spring, damper and dry friction are the joint's; a flow source keeps its own in the actuator.
  void put_joint(int i) {
    const Joint& j = joint(i);
    xml_.open("joint").set("name", j.name).set("type", j.prismatic() ? "slide" : "hinge").set("axis", j.axis);
    if (std::isfinite(j.lower) && std::isfinite(j.upper)) xml_.set("limited", "true").set("range", {j.lower, j.upper});
    if (actuator(i).type >= 0 && model_name(i) != "flow_source") {
      const Values p(model_, actuator(i), values_);
      if (p.has("damping")) xml_.set("damping", p["damping"]);
      if (p.has("stiffness")) xml_.set("stiffness", p["stiffness"]).set("springref", p["rest"]);
    }
    const double friction = sum_over_effects(i, {"coulomb_friction", "stribeck_friction"}, "Fc");
    if (friction > 0.0) xml_.set("frictionloss", friction);
    const double armature = armatures_[i];
    if (armature > 0.0) xml_.set("armature", armature);
    xml_.close();
  }

  double sum_over_effects(int i, std::initializer_list<std::string_view> names, const char* parameter) const {
    double sum = 0.0;
    for (const Component& effect : model_.effects()) {
      const std::string_view name = effect_table()[effect.type].name;
      if (effect.joint == i && std::find(names.begin(), names.end(), name) != names.end())
        sum += Values(model_, effect, values_)[parameter];
    }
    return sum;
  }

  /// The control is the recording's command, in its own unit.
  void put_actuator(int i) {
    const Values p(model_, actuator(i), values_);
    const std::string& name = joint(i).name;
    const auto begin = [&](const char* element) { xml_.open(element).set("name", name).set("joint", name); };
    if (model_name(i) == "flow_source") {
      put_comment(xml_, name + ": flow_source, " + p.words() +
                            "; its damper acts against the joint's speed alone, and the oil position starts at 0");
      begin("general");
      xml_.set("dyntype", "integrator").set("gainprm", p["stiffness"] * p["gain"]).set("biastype", "affine");
      xml_.set("biasprm", {0.0, -p["stiffness"], -p["damping"]});
    } else if (actuator_table()[actuator(i).type].chambers) {
      put_comment(
          xml_, name + ": hydraulic, " + p.words() + "; its chambers are not in this file: the control is the effort");
      begin("motor");
    } else {
      begin("general");
      const double offset = sum_over_effects(i, {"valve_offset"}, "b");
      xml_.set("gainprm", p["gain"]).set("biastype", "affine").set("biasprm", {p["gain"] * offset, 0.0, 0.0});
      put_valve(i);
    }
    xml_.close();
  }

  /// A lag is MuJoCo's filter; a saturation the control's range, where it is hard.
  void put_valve(int i) {
    const double lag = sum_over_effects(i, {"actuator_lag"}, "T");
    if (lag > 0.0) xml_.set("dyntype", "filter").set("dynprm", lag);
    const double cap = sum_over_effects(i, {"actuator_saturation"}, "cap");
    if (cap > 0.0 && std::isfinite(cap)) xml_.set("ctrllimited", "true").set("ctrlrange", {-cap, cap});
  }

  std::string in_words(const Component& effect) const {
    const EffectInfo& info = effect_table()[effect.type];
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
    return text;
  }

  const PlantModel& model_;
  std::span<const double> values_;
  const Robot& robot_;
  std::vector<Inertial> inertials_;
  std::vector<double> armatures_;  ///< kg m^2 or kg, per joint
  XmlWriter xml_;
};

}  // namespace

std::string to_mjcf(const PlantModel& model, std::span<const double> values) { return Writer(model, values).str(); }

std::vector<std::string> plant_in_words(const PlantModel& model, std::span<const double> values) {
  std::vector<std::string> out;
  const auto add = [&](const auto& info, const Component& component) {
    out.push_back(printable(fmt::format("{} at {}: {}, {}", info.name, model.place_name(component), info.equation,
                                        Values(model, component, values).words()),
                            1000));
  };
  for (const Component& actuator : model.actuators())
    if (actuator.type >= 0) add(actuator_table()[actuator.type], actuator);
  for (const Component& effect : model.effects()) add(effect_table()[effect.type], effect);
  return out;
}

}  // namespace lacuna
