// Robot from URDF: the outline is checked first, urdfdom reads the geometry, fixed joints are folded away.
#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <limits>
#include <mutex>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/inertial.h"
#include "scenarios/robot.h"
#include "scenarios/text.h"
#include "scenarios/urdf_outline.h"

namespace lacuna {
namespace {

constexpr std::uintmax_t kMaxUrdfBytes = std::uintmax_t{16} << 20;
constexpr double kShortestAxis = 1e-6;
/// URDF cannot write infinity: limits this large mean none (to_urdf writes them so).
constexpr double kUnlimited = 1e300;

double to_limit(double value) {
  return std::abs(value) < kUnlimited ? value : std::copysign(std::numeric_limits<double>::infinity(), value);
}

/// Keeps urdfdom's errors instead of printing them.
class Listener : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR || said_.size() > 300) return;
    said_ += (said_.empty() ? "" : "; ") + text;
  }
  const std::string& said() const { return said_; }

 private:
  std::string said_;
};

/// urdfdom's model; console_bridge is one per process, so one reader at a time.
urdf::ModelInterfaceSharedPtr parse_model(const std::string& xml, const std::string& source) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  Listener listener;
  console_bridge::useOutputHandler(&listener);
  urdf::ModelInterfaceSharedPtr model;
  std::string reason;
  try {
    model = urdf::parseURDF(xml);
  } catch (const std::exception& error) {
    reason = error.what();
  }
  console_bridge::restorePreviousOutputHandler();
  if (model) return model;
  if (reason.empty()) reason = listener.said();
  throw InputError(printable(source),
                   "no usable URDF (" + printable(reason.empty() ? "no reason given" : reason, 300) + ")",
                   "a URDF robot");
}

/// Two XML readers see the file: where its declaration or a comment is malformed they may take different elements for
/// the robot.
void check_alike(const urdf::ModelInterface& model, const UrdfOutline& outline, const std::string& source) {
  bool alike = model.links_.size() == outline.links.size() && model.joints_.size() == outline.joints.size();
  for (const auto& link : outline.links) alike = alike && model.getLink(link.name);
  for (const auto& joint : outline.joints) alike = alike && model.getJoint(joint.name);
  if (!alike)
    throw InputError(printable(source), "malformed XML, of which readers make different robots",
                     "one <robot> after a well-formed XML declaration");
}

Eigen::Isometry3d to_pose(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  out.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return out;
}

Inertial to_inertial(const urdf::Inertial& in, const std::string& where) {
  Inertial own{in.mass, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  own.inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
  check_inertial(own, where);
  return own.seen_from(to_pose(in.origin));
}

class Converter {
 public:
  Converter(const urdf::ModelInterface& model, const UrdfOutline& outline, std::vector<std::string>& notes)
      : model_(model), outline_(outline), notes_(notes), links_(outline.links.size()) {}

  std::shared_ptr<const Robot> run(const std::string& source) {
    place_link(outline_.root, -1, Eigen::Isometry3d::Identity());
    for (const auto& entry : outline_.joints) {
      const urdf::Joint& joint = *model_.getJoint(entry.name);
      const Link& parent = links_[entry.parent];
      const Eigen::Isometry3d origin = parent.in_body * to_pose(joint.parent_to_joint_origin_transform);
      note_ignored(joint);
      if (entry.type == "fixed") {
        place_link(entry.child, parent.body, origin);
      } else {
        joints_.push_back(to_joint(joint, entry, parent.body, origin));
        place_link(entry.child, static_cast<int>(joints_.size()) - 1, Eigen::Isometry3d::Identity());
      }
    }
    return std::make_shared<const Robot>(model_.getName(), std::move(joints_), std::move(links_), source);
  }

 private:
  void place_link(int index, int body, const Eigen::Isometry3d& in_body) {
    const auto& entry = outline_.links[index];
    const urdf::Link& in = *model_.getLink(entry.name);
    Link& link = links_[index];
    link.name = entry.name;
    link.body = body;
    link.in_body = in_body;
    if (in.inertial) link.inertial = to_inertial(*in.inertial, entry.where);
    for (const auto& visual : in.visual_array) add_visual(*visual, link);
  }

  void add_visual(const urdf::Visual& in, Link& link) {
    Visual visual;
    visual.pose = to_pose(in.origin);
    if (in.material)
      visual.rgba = {in.material->color.r, in.material->color.g, in.material->color.b, in.material->color.a};
    if (!in.geometry) return;
    switch (in.geometry->type) {
      case urdf::Geometry::BOX: {
        const auto& size = static_cast<const urdf::Box&>(*in.geometry).dim;
        visual.shape = Visual::Shape::box;
        visual.size = {size.x, size.y, size.z};
        break;
      }
      case urdf::Geometry::CYLINDER: {
        const auto& cylinder = static_cast<const urdf::Cylinder&>(*in.geometry);
        visual.shape = Visual::Shape::cylinder;
        visual.size = {cylinder.radius, cylinder.length, 0.0};
        break;
      }
      case urdf::Geometry::SPHERE:
        visual.shape = Visual::Shape::sphere;
        visual.size = {static_cast<const urdf::Sphere&>(*in.geometry).radius, 0.0, 0.0};
        break;
      case urdf::Geometry::MESH: {
        const auto& mesh = static_cast<const urdf::Mesh&>(*in.geometry);
        visual.shape = Visual::Shape::mesh;
        visual.mesh_file = mesh.filename;
        visual.mesh_scale = {mesh.scale.x, mesh.scale.y, mesh.scale.z};
        break;
      }
      default: return;
    }
    link.visuals.push_back(visual);
  }

  static Joint to_joint(const urdf::Joint& in, const UrdfOutline::JointEntry& entry, int parent,
                        const Eigen::Isometry3d& origin) {
    Joint joint;
    joint.name = entry.name;
    joint.type = entry.type == "revolute"     ? JointType::revolute
                 : entry.type == "continuous" ? JointType::continuous
                                              : JointType::prismatic;
    joint.parent = parent;
    joint.link = entry.child;
    joint.origin = origin;
    joint.axis = {in.axis.x, in.axis.y, in.axis.z};
    const double length = joint.axis.norm();
    if (!(length > kShortestAxis) || !std::isfinite(length))
      throw InputError(entry.where + ": axis", fmt::format("length {:.3g}", length), "a direction");
    joint.axis /= length;
    if (!in.limits) return joint;
    joint.velocity = to_limit(in.limits->velocity);
    joint.effort = to_limit(in.limits->effort);
    if (joint.type == JointType::continuous) return joint;
    joint.lower = to_limit(in.limits->lower);
    joint.upper = to_limit(in.limits->upper);
    if (!(joint.lower <= joint.upper))
      throw InputError(entry.where + ": limit",
                       fmt::format("lower {} above upper {}", format_number(joint.lower), format_number(joint.upper)),
                       "lower not above upper");
    return joint;
  }

  void note_ignored(const urdf::Joint& joint) {
    const std::string name = "joint " + printable(joint.name, 60);
    if (joint.mimic) notes_.push_back(name + ": its mimic rule is ignored, it moves on its own");
    if (joint.dynamics && (joint.dynamics->damping != 0.0 || joint.dynamics->friction != 0.0))
      notes_.push_back(name + ": its <dynamics> is ignored, damping and friction belong to the scenario");
  }

  const urdf::ModelInterface& model_;
  const UrdfOutline& outline_;
  std::vector<std::string>& notes_;
  std::vector<Joint> joints_;
  std::vector<Link> links_;
};

}  // namespace

std::shared_ptr<const Robot> Robot::from_urdf(const std::filesystem::path& file, std::vector<std::string>* notes) {
  return from_urdf_text(read_text_file(file, file.string(), "a URDF file", kMaxUrdfBytes), file.string(), notes);
}

std::shared_ptr<const Robot> Robot::from_urdf_text(const std::string& xml, const std::string& source,
                                                   std::vector<std::string>* notes) {
  if (xml.size() > kMaxUrdfBytes)
    throw InputError(printable(source), fmt::format("{} bytes", xml.size()), fmt::format("at most {}", kMaxUrdfBytes));
  const UrdfOutline outline = outline_urdf(scan_xml(xml, source), source);
  const auto model = parse_model(xml, source);
  check_alike(*model, outline, source);
  std::vector<std::string> ignored;
  auto robot = Converter(*model, outline, notes != nullptr ? *notes : ignored).run(source);
  return robot;
}

}  // namespace lacuna
