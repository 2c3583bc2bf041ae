#include "scenarios/mjcf_geom.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr double kWater = 1000.0;  // kg/m^3, MuJoCo's default density

/// Half extents along x, y, z or radius and half length, with the pose; `fromto` sets length and direction.
struct Shape {
  std::string type;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

std::size_t sizes_of(const std::string& type) {
  if (type == "sphere") return 1;
  return type == "cylinder" || type == "capsule" ? 2 : 3;
}

Shape shape_of(const MjcfAttributes& attributes, int element) {
  Shape out{attributes.text(element, "type").value_or("sphere"), Eigen::Vector3d::Zero(), attributes.pose(element)};
  const auto ends = attributes.numbers(element, "fromto", 6, 6);
  const std::size_t needed = sizes_of(out.type) - (ends && out.type != "sphere" ? 1 : 0);
  const auto size = attributes.numbers(element, "size", 1, 3);
  if (!size || size->size() < needed) attributes.refuse(element, "too few sizes", std::to_string(needed));
  for (std::size_t i = 0; i < size->size(); ++i) out.size[static_cast<Eigen::Index>(i)] = (*size)[i];
  if (ends) {
    const Eigen::Vector3d from(ends->data()), to(ends->data() + 3), along = to - from;
    if (!(along.norm() > 1e-12)) attributes.refuse(element, "fromto of no length", "two points");
    if (out.type == "box" || out.type == "ellipsoid") out.size[1] = out.size[0];
    out.size[out.type == "box" || out.type == "ellipsoid" ? 2 : 1] = 0.5 * along.norm();
    out.pose.translation() = 0.5 * (from + to);
    out.pose.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along).toRotationMatrix();
  }
  for (std::size_t i = 0; i < sizes_of(out.type); ++i)
    if (!(out.size[static_cast<Eigen::Index>(i)] > 0.0)) attributes.refuse(element, "a size that is not positive", "m");
  return out;
}

double volume_of(const Shape& shape) {
  constexpr double kPi = std::numbers::pi;
  const Eigen::Vector3d& s = shape.size;
  if (shape.type == "box") return 8.0 * s.prod();
  if (shape.type == "sphere") return 4.0 / 3.0 * kPi * s[0] * s[0] * s[0];
  if (shape.type == "ellipsoid") return 4.0 / 3.0 * kPi * s.prod();
  const double cylinder = 2.0 * kPi * s[0] * s[0] * s[1];
  return shape.type == "cylinder" ? cylinder : cylinder + 4.0 / 3.0 * kPi * s[0] * s[0] * s[0];
}

/// About the centre, of mass 1.
Eigen::Vector3d unit_inertia(const Shape& shape) {
  const Eigen::Vector3d s = shape.size, squares = s.cwiseProduct(s);
  const auto across = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x[1] + x[2], x[0] + x[2], x[0] + x[1]); };
  if (shape.type == "box") return across(squares) / 3.0;
  if (shape.type == "sphere") return Eigen::Vector3d::Constant(0.4 * squares[0]);
  if (shape.type == "ellipsoid") return across(squares) / 5.0;
  const double r2 = squares[0], h = s[1], round = (3.0 * r2 + 4.0 * h * h) / 12.0;
  const Eigen::Vector3d cylinder(round, round, 0.5 * r2);
  if (shape.type == "cylinder") return cylinder;
  // A capsule: a cylinder and two half spheres at its ends.
  const double ends = 4.0 / 3.0 * s[0] / (2.0 * h + 4.0 / 3.0 * s[0]);  // share of the volume
  const double tilt = 0.4 * r2 + h * h + 0.75 * h * s[0];
  return (1.0 - ends) * cylinder + ends * Eigen::Vector3d(tilt, tilt, 0.4 * r2);
}

std::optional<Visual> visual_of(const Shape& shape) {
  Visual out;
  out.pose = shape.pose;
  const Eigen::Vector3d& s = shape.size;
  if (shape.type == "box") {
    out.shape = Visual::Shape::box, out.size = 2.0 * s;
  } else if (shape.type == "sphere") {
    out.shape = Visual::Shape::sphere, out.size = {s[0], 0.0, 0.0};
  } else if (shape.type == "cylinder" || shape.type == "capsule") {
    out.shape = Visual::Shape::cylinder, out.size = {s[0], 2.0 * s[1], 0.0};
  } else {
    return std::nullopt;
  }
  return out;
}

}  // namespace

MjcfGeom read_mjcf_geom(const MjcfAttributes& attributes, int element) {
  const std::string type = attributes.text(element, "type").value_or("sphere");
  MjcfGeom out;
  if (type == "plane" || type == "hfield") return out;
  if (type == "mesh" || attributes.text(element, "mesh")) {
    out.mesh = attributes.number(element, "mass", 1.0) != 0.0;
    return out;
  }
  if (type != "box" && type != "sphere" && type != "cylinder" && type != "capsule" && type != "ellipsoid")
    attributes.refuse(element, "a geom of type " + quoted(type),
                      "box, sphere, cylinder, capsule, ellipsoid, plane or mesh");
  if (attributes.text(element, "shellinertia").value_or("false") == "true")
    attributes.refuse(element, "shellinertia", "a solid");
  const Shape shape = shape_of(attributes, element);
  const double density = attributes.number(element, "density", kWater);
  const double mass = attributes.number(element, "mass", density * volume_of(shape));
  if (!(mass >= 0.0) || !std::isfinite(mass)) attributes.refuse(element, "a mass that is not one", "kg, from 0");
  const Eigen::Matrix3d turn = shape.pose.linear();
  out.inertial = {mass, shape.pose.translation(), turn * (mass * unit_inertia(shape)).asDiagonal() * turn.transpose()};
  out.visual = visual_of(shape);
  if (const auto color = attributes.numbers(element, "rgba", 4, 4); color && out.visual)
    for (std::size_t i = 0; i < 4; ++i) out.visual->rgba[i] = static_cast<float>(std::clamp((*color)[i], 0.0, 1.0));
  return out;
}

}  // namespace lacuna
