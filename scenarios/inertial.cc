#include "scenarios/inertial.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

/// Inertia of a point mass at `offset` from the centre.
Eigen::Matrix3d point_inertia(double mass, const Eigen::Vector3d& offset) {
  return mass * (offset.squaredNorm() * Eigen::Matrix3d::Identity() - offset * offset.transpose());
}

}  // namespace

Inertial Inertial::seen_from(const Eigen::Isometry3d& pose) const {
  const Eigen::Matrix3d rotation = pose.linear();
  return {mass, pose * com, rotation * inertia * rotation.transpose()};
}

Inertial Inertial::scaled(double factor) const { return {factor * mass, com, factor * inertia}; }

Inertial welded(const Inertial& a, const Inertial& b) {
  const double mass = a.mass + b.mass;
  if (!(mass > 0.0)) return {0.0, a.com, a.inertia + b.inertia};
  const Eigen::Vector3d com = (a.mass * a.com + b.mass * b.com) / mass;
  return {mass, com, a.inertia + point_inertia(a.mass, a.com - com) + b.inertia + point_inertia(b.mass, b.com - com)};
}

void check_inertial(const Inertial& inertial, const std::string& where) {
  const auto moment = [](double value) { return fmt::format("{:.6g}", value); };
  if (!std::isfinite(inertial.mass) || !inertial.com.allFinite() || !inertial.inertia.allFinite())
    throw InputError(where, "a number that is not finite", "finite mass, centre of mass and inertia");
  if (!(inertial.mass > 0.0)) throw InputError(where + ": mass", format_number(inertial.mass), "a mass above 0 kg");
  const double size = inertial.inertia.cwiseAbs().maxCoeff();
  if ((inertial.inertia - inertial.inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size)
    throw InputError(where + ": inertia", "a matrix that is not symmetric", "a symmetric one");
  if (size == 0.0) return;  // a point mass
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertial.inertia / size, Eigen::EigenvaluesOnly).eigenvalues() *
      size;
  const double slack = kRoundedTableSlack * principal.cwiseAbs().sum();
  const std::string found = fmt::format("principal moments {}, {} and {} kg m^2", moment(principal[0]),
                                        moment(principal[1]), moment(principal[2]));
  if (principal[0] < -slack) throw InputError(where + ": inertia", found, "none below 0");
  if (principal[0] + principal[1] < principal[2] - slack)
    throw InputError(where + ": inertia", found,
                     "the two smaller ones to add up to at least the largest (triangle inequality of any rigid body)");
}

}  // namespace lacuna
