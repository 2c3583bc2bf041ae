#include "scenarios/mjcf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/mjcf_attributes.h"
#include "scenarios/mjcf_geom.h"
#include "scenarios/text.h"
#include "scenarios/xml_scan.h"

namespace lacuna {
namespace {

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{16} << 20;
constexpr std::size_t kMostBodies = 1000;

/// What drives and holds a joint, summed up.
struct Drive {
  double gain = 0.0, damping = 0.0, stiffness = 0.0, stiffness_times_rest = 0.0;
  double armature = 0.0, friction = 0.0, bias = 0.0, lag = 0.0;
  bool driven = false;
  std::string where;
};

class Reader {
 public:
  Reader(const std::string& xml, const std::string& source, std::vector<std::string>* notes)
      : source_(source), elements_(scan_xml(xml, source)), attributes_(elements_, source), notes_(notes) {
    if (elements_[0].tag != "mujoco") attributes_.refuse(0, quoted(elements_[0].tag), "the root element mujoco");
    children_.resize(elements_.size());
    for (std::size_t i = 1; i < elements_.size(); ++i) children_[elements_[i].parent].push_back(static_cast<int>(i));
  }

  MjcfModel read() {
    refuse_sections();
    links_.push_back({"world", -1, Eigen::Isometry3d::Identity(), {}, {}});
    for (const int section : children_[0])
      if (tag(section) == "worldbody") read_bodies(section, {-1, Eigen::Isometry3d::Identity(), 0});
    for (const int section : children_[0])
      if (tag(section) == "actuator")
        for (const int actuator : children(section)) read_actuator(actuator);
    const std::string* model = elements_[0].find("model");
    const std::string name = model != nullptr && !model->empty() ? *model : "mujoco";
    MjcfModel out;
    for (const int section : children_[0])
      if (tag(section) == "option") {
        refuse_option(section);
        out.gravity = attributes_.vector(section, "gravity", out.gravity);
      }
    out.robot = std::make_shared<const Robot>(name, joints_, links_, source_);
    for (std::size_t j = 0; j < joints_.size(); ++j) state_drive(joints_[j].name, drives_[j], out);
    return out;
  }

 private:
  /// A body's frame as seen from the moving body that carries it.
  struct Frame {
    int carrier = -1;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    int link = 0;
  };

  const std::string& tag(int element) const { return elements_[element].tag; }
  const std::vector<int>& children(int element) const { return children_[element]; }
  void note(const std::string& text) {
    if (notes_ != nullptr && noted_.insert(text).second) notes_->push_back(text);
  }

  std::string name_of(int element, const std::string& otherwise) const {
    const std::string* name = elements_[element].find("name");
    return name != nullptr && !name->empty() ? *name : otherwise;
  }

  /// What would change the dynamics and is not modelled.
  void refuse_set(int element, std::initializer_list<const char*> keys, const char* expected) const {
    for (const char* key : keys)
      if (const auto set = attributes_.numbers(element, key, 1, 2);
          set && std::ranges::any_of(*set, [](double x) { return x != 0.0; }))
        attributes_.refuse(element, key, expected);
  }

  void refuse_option(int option) const {
    refuse_set(option, {"density", "viscosity"}, "no fluid around the robot");
    for (const int flag : children(option)) {
      if (tag(flag) != "flag") continue;
      for (const char* key : {"gravity", "passive", "actuation", "frictionloss"})
        if (attributes_.text(flag, key).value_or("enable") == "disable")
          attributes_.refuse(flag, std::string(key) + " disabled", "enabled, as a machine has it");
    }
  }

  void refuse_sections() {
    static const std::set<std::string> kHarmless{"compiler",  "option",   "size",   "visual",
                                                 "statistic", "default",  "asset",  "custom",
                                                 "worldbody", "actuator", "sensor", "keyframe"};
    for (const int section : children_[0]) {
      const std::string& name = tag(section);
      if (kHarmless.count(name) > 0 || children(section).empty()) continue;
      if (name == "contact")
        note("contacts are not modelled");
      else if (name == "equality")
        attributes_.refuse(children(section)[0], "an equality constraint",
                           "a tree of joints: closed chains are not modelled");
      else if (name == "tendon")
        attributes_.refuse(children(section)[0], "a tendon", "actuators at joints: tendons are not modelled");
      else
        attributes_.refuse(section, "a section that is not understood", "worldbody and actuator");
    }
  }

  void read_bodies(int parent, const Frame& frame) {
    // The world's own geoms are drawn only.
    if (tag(parent) == "worldbody") take_geoms(parent, frame, false);
    for (const int child : children(parent)) {
      if (tag(child) == "body")
        read_body(child, frame);
      else if (tag(child) == "frame" || tag(child) == "replicate" || tag(child) == "composite" ||
               tag(child) == "flexcomp" || tag(child) == "attach")
        attributes_.refuse(child, "an element that is not understood", "bodies, joints and geoms");
    }
  }

  void read_body(int element, const Frame& parent) {
    if (links_.size() > kMostBodies)
      attributes_.refuse(element, "one body more", fmt::format("at most {}", kMostBodies));
    refuse_set(element, {"gravcomp"}, "a body with its whole weight");
    const Eigen::Isometry3d pose = parent.pose * attributes_.pose(element);
    Frame frame{parent.carrier, pose, static_cast<int>(links_.size())};
    Link link;
    link.name = name_of(element, fmt::format("body_{}", links_.size()));
    const int joint = joint_of(element);
    if (joint >= 0) {
      const Eigen::Vector3d anchor = attributes_.vector(joint, "pos", Eigen::Vector3d::Zero());
      read_joint(joint, parent.carrier, pose * Eigen::Translation3d(anchor));
      // The moving body's frame lies in the joint; the file's own frame is moved back by the anchor.
      frame.carrier = static_cast<int>(joints_.size()) - 1;
      frame.pose = Eigen::Isometry3d(Eigen::Translation3d(-anchor));
      link.body = frame.carrier;
    } else {
      link.body = parent.carrier, link.in_body = pose;
    }
    links_.push_back(std::move(link));
    take_inertial(element, frame, joint >= 0);
    read_bodies(element, frame);
  }

  int joint_of(int body) const {
    int found = -1;
    for (const int child : children(body)) {
      if (tag(child) == "freejoint") attributes_.refuse(child, "a free joint", "a base that is fixed to the world");
      if (tag(child) != "joint") continue;
      if (found >= 0)
        attributes_.refuse(child, "a second joint in one body", "one joint a body: put a body between them");
      found = child;
    }
    return found;
  }

  void read_joint(int element, int parent, const Eigen::Isometry3d& origin) {
    refuse_set(element, {"springdamper"}, "stiffness and damping");
    Joint joint;
    joint.name = name_of(element, fmt::format("joint_{}", joints_.size() + 1));
    const std::string type = attributes_.text(element, "type").value_or("hinge");
    if (type != "hinge" && type != "slide")
      attributes_.refuse(element, "a joint of type " + quoted(type), "hinge or slide");
    if (attributes_.number(element, "ref", 0.0) != 0.0)
      attributes_.refuse(element, "a ref that is not 0", "positions that count from the body's own pose");
    joint.parent = parent, joint.link = static_cast<int>(links_.size()), joint.origin = origin;
    const Eigen::Vector3d axis = attributes_.vector(element, "axis", Eigen::Vector3d::UnitZ());
    if (!(axis.norm() > 1e-6)) attributes_.refuse(element, "an axis of length 0", "a direction");
    joint.axis = axis.normalized();
    const bool slide = type == "slide";
    const auto range = attributes_.numbers(element, "range", 2, 2);
    const std::string limited = attributes_.text(element, "limited").value_or("auto");
    const bool has_limits = range && limited != "false" && (*range)[0] < (*range)[1];
    joint.type = slide ? JointType::prismatic : has_limits ? JointType::revolute : JointType::continuous;
    if (has_limits) {
      joint.lower = slide ? (*range)[0] : attributes_.angle((*range)[0]);
      joint.upper = slide ? (*range)[1] : attributes_.angle((*range)[1]);
      note("joint limits are not modelled");
    }
    joints_.push_back(joint);
    drives_.push_back(passive_drive(element, slide));
  }

  /// What is the joint's own: damper, spring, dry friction, the motor's inertia.
  Drive passive_drive(int element, bool slide) const {
    const auto positive = [&](const char* name) {
      const double value = attributes_.number(element, name, 0.0);
      if (value < 0.0) attributes_.refuse(element, fmt::format("{} {}", name, format_number(value)), "a number from 0");
      return value;
    };
    Drive out;
    out.where = attributes_.where(element);
    out.damping = positive("damping"), out.stiffness = positive("stiffness");
    const double rest = attributes_.number(element, "springref", 0.0);
    out.stiffness_times_rest = out.stiffness * (slide ? rest : attributes_.angle(rest));
    out.armature = positive("armature"), out.friction = positive("frictionloss");
    return out;
  }

  void take_inertial(int body, const Frame& frame, bool moves) {
    int inertial = -1;
    for (const int child : children(body))
      if (tag(child) == "inertial") inertial = child;
    const bool from_geoms = attributes_.inertia_from_geoms(inertial >= 0);
    take_geoms(body, frame, from_geoms);
    if (!from_geoms && inertial >= 0) weld(frame, read_inertial(inertial));
    const double mass = links_[frame.link].inertial.mass;
    if (moves && !(mass > 0.0) && children_have_no_mass(body))
      attributes_.refuse(body, "a moving body without mass", "an inertial, or geoms of simple shape");
  }

  /// A body may be weighed by what is fixed to it: then Robot's own check decides.
  bool children_have_no_mass(int body) const {
    return std::none_of(children(body).begin(), children(body).end(), [&](int child) { return tag(child) == "body"; });
  }

  Inertial read_inertial(int element) const {
    Inertial out;
    if (!attributes_.text(element, "mass")) attributes_.refuse(element, "no mass", "mass=\"...\", kg");
    out.mass = attributes_.number(element, "mass", 0.0);
    if (!(out.mass >= 0.0)) attributes_.refuse(element, "a mass below 0", "kg");
    const Eigen::Isometry3d pose = attributes_.pose(element);
    Eigen::Matrix3d local = Eigen::Matrix3d::Zero();
    if (const auto full = attributes_.numbers(element, "fullinertia", 6, 6)) {
      const std::vector<double>& f = *full;
      local << f[0], f[3], f[4], f[3], f[1], f[5], f[4], f[5], f[2];
    } else if (const auto diagonal = attributes_.numbers(element, "diaginertia", 3, 3)) {
      local.diagonal() = Eigen::Vector3d(diagonal->data());
    } else if (out.mass > 0.0) {
      attributes_.refuse(element, "no inertia", "diaginertia or fullinertia");
    }
    out.com = pose.translation();
    out.inertia = pose.linear() * local * pose.linear().transpose();
    return out;
  }

  /// `inertial` in the file's body frame, into the link.
  void weld(const Frame& frame, const Inertial& inertial) {
    Link& link = links_[frame.link];
    const Inertial seen = inertial.seen_from(in_link(frame));
    link.inertial = link.inertial.mass > 0.0 ? welded(link.inertial, seen) : seen;
  }

  /// The file's body frame in the link's: apart only by a joint's anchor.
  Eigen::Isometry3d in_link(const Frame& frame) const { return links_[frame.link].in_body.inverse() * frame.pose; }

  void take_geoms(int body, const Frame& frame, bool weigh) {
    for (const int child : children(body)) {
      if (tag(child) != "geom") continue;
      MjcfGeom geom = read_mjcf_geom(attributes_, child);
      Link& link = links_[frame.link];
      if (geom.mesh && weigh) attributes_.refuse(child, "a mesh that should say what the body weighs", "an inertial");
      if (geom.mesh) note("link " + printable(link.name, 60) + ": its mesh is not drawn");
      if (weigh && geom.inertial.mass > 0.0) weld(frame, geom.inertial);
      if (!geom.visual) continue;
      geom.visual->pose = in_link(frame) * geom.visual->pose;
      link.visuals.push_back(*geom.visual);
    }
  }

  /// force = gear (gain u + bias0 + bias1 gear q + bias2 gear v), MuJoCo documentation, "Actuation model".
  void read_actuator(int element) {
    const std::string kind = tag(element), shown = printable(name_of(element, kind), 60);
    const auto joint_name = attributes_.text(element, "joint");
    if (!joint_name) return note("actuator " + shown + ": left out, it acts on no joint");
    const auto at = std::find_if(joints_.begin(), joints_.end(), [&](const Joint& j) { return j.name == *joint_name; });
    if (at == joints_.end()) attributes_.refuse(element, "the joint " + quoted(*joint_name), "a joint of the file");
    if (kind != "motor" && kind != "general" && kind != "position" && kind != "velocity")
      return note("actuator " + shown + ": left out, a " + printable(kind, 40) + " is not understood");
    Drive& drive = drives_[at - joints_.begin()];
    if (drive.driven) attributes_.refuse(element, "a second actuator of " + quoted(*joint_name), "one a joint");
    const auto gears = attributes_.numbers(element, "gear", 1, 6);
    const double gear = gears ? gears->front() : 1.0;
    if (gear == 0.0) attributes_.refuse(element, "a gear of 0", "a ratio");
    double gain = 1.0, bias[3] = {0.0, 0.0, 0.0};
    if (kind == "position") {
      gain = attributes_.number(element, "kp", 1.0), bias[1] = -gain;
      bias[2] = -attributes_.number(element, "kv", 0.0);
      refuse_set(element, {"dampratio", "timeconst"}, "kp and kv");
    }
    if (kind == "velocity") gain = attributes_.number(element, "kv", 1.0), bias[2] = -gain;
    if (kind == "general" && !read_general(element, shown, gain, bias, drive.lag)) return;
    drive.driven = true;
    drive.where = attributes_.where(element);
    drive.gain = gear * gain, drive.bias = gear * bias[0];
    drive.damping -= gear * gear * bias[2], drive.stiffness -= gear * gear * bias[1];
    if (attributes_.text(element, "ctrlrange") || attributes_.text(element, "forcerange"))
      note("actuator " + shown + ": its control and force ranges are not modelled");
  }

  /// A general actuator that is a gain with an affine bias, maybe behind a filter; else false, noted.
  bool read_general(int element, const std::string& shown, double& gain, double (&bias)[3], double& lag) {
    const std::string gain_type = attributes_.text(element, "gaintype").value_or("fixed");
    const std::string bias_type = attributes_.text(element, "biastype").value_or("none");
    const std::string dynamics = attributes_.text(element, "dyntype").value_or("none");
    if (gain_type != "fixed" || (bias_type != "none" && bias_type != "affine") ||
        (dynamics != "none" && dynamics != "filter")) {
      note(fmt::format("actuator {}: left out, {} {} {} is not understood", shown, printable(gain_type, 30),
                       printable(bias_type, 30), printable(dynamics, 30)));
      return false;
    }
    if (const auto values = attributes_.numbers(element, "gainprm", 1, 10)) gain = values->front();
    if (const auto values = attributes_.numbers(element, "biasprm", 1, 10); values && bias_type == "affine")
      for (std::size_t i = 0; i < std::min<std::size_t>(3, values->size()); ++i) bias[i] = (*values)[i];
    if (dynamics == "filter") {
      const auto values = attributes_.numbers(element, "dynprm", 1, 10);
      lag = values ? values->front() : 1.0;
    }
    return true;
  }

  static void state_drive(const std::string& joint, const Drive& drive, MjcfModel& out) {
    const auto effect = [&](const char* name, const char* parameter, double value) {
      if (value != 0.0) out.effects.push_back({name, joint, {{parameter, value}}, {}, drive.where});
    };
    effect("armature", "J", drive.armature);
    effect("coulomb_friction", "Fc", drive.friction);
    if (!drive.driven && drive.damping == 0.0 && drive.stiffness == 0.0) return;
    // Without an actuator there is no command either: the gain stands for nothing.
    ActuatorSpec spec{
        joint, "direct_effort", {{"gain", drive.driven ? drive.gain : 1.0}, {"damping", drive.damping}}, drive.where};
    if (drive.stiffness != 0.0) {
      spec.model = "torque_source";
      spec.parameters["stiffness"] = drive.stiffness;
      spec.parameters["rest"] = drive.stiffness_times_rest / drive.stiffness;
    }
    if (drive.gain != 0.0) effect("valve_offset", "b", drive.bias / drive.gain);
    effect("actuator_lag", "T", drive.lag);
    out.actuators.push_back(std::move(spec));
  }

  std::string source_;
  std::vector<XmlElement> elements_;
  MjcfAttributes attributes_;
  std::vector<std::string>* notes_;
  std::set<std::string> noted_;
  std::vector<std::vector<int>> children_;
  std::vector<Joint> joints_;
  std::vector<Link> links_;
  std::vector<Drive> drives_;  ///< one a joint
};

/// The first element's tag; whatever is no XML is left to the readers to refuse.
bool begins_with(const std::string& xml, const std::string& tag) {
  std::size_t at = 0;
  while ((at = xml.find('<', at)) != std::string::npos) {
    if (xml.compare(at, 4, "<!--") == 0) {
      at = xml.find("-->", at);
    } else if (at + 1 < xml.size() && (xml[at + 1] == '?' || xml[at + 1] == '!')) {
      ++at;
    } else {
      return xml.compare(at + 1, tag.size(), tag) == 0;
    }
  }
  return false;
}

}  // namespace

namespace {

/// An element of it, not a comment that xacro left behind.
bool holds_xacro(const std::string& xml, const std::string& source) {
  if (xml.find("<xacro:") == std::string::npos) return false;
  const auto elements = scan_xml(xml, source);
  return std::ranges::any_of(elements, [](const XmlElement& e) { return e.tag.rfind("xacro:", 0) == 0; });
}

}  // namespace

MjcfModel read_mjcf_text(const std::string& xml, const std::string& source, std::vector<std::string>* notes) {
  return Reader(xml, source, notes).read();
}

MjcfModel read_robot_file(const std::filesystem::path& file, std::vector<std::string>* notes) {
  const std::string name = file.string();
  const std::string xml = read_text_file(file, name, "a robot's file (URDF or MJCF)", kMaxBytes);
  if (file.extension() == ".xacro" || holds_xacro(xml, name))
    throw InputError(printable(name), "a xacro file",
                     "the URDF that `xacro " + printable(file.filename().string()) + " > robot.urdf` makes of it");
  if (begins_with(xml, "mujoco")) return read_mjcf_text(xml, name, notes);
  MjcfModel out;
  out.robot = Robot::from_urdf(file, notes);
  return out;
}

}  // namespace lacuna
