// A user's first program: a two-link pendulum built by hand, its acceleration against the closed form.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "backends/engine.h"
#include "scenarios/robot.h"

namespace {

constexpr double kLength = 0.7;    // m, of each rod
constexpr double kMass = 2.0;      // kg, of each rod
constexpr double kGravity = 9.81;  // m/s^2
// About the centre and across a uniform slender rod; along it a hundredth of that, which a planar motion never feels.
constexpr double kInertia = kMass * kLength * kLength / 12.0;

/// Two equal rods hanging in the x-z plane, turning about y; q = 0 hangs straight down.
std::shared_ptr<const lacuna::Robot> two_rods() {
  std::vector<lacuna::Link> links(3);
  std::vector<lacuna::Joint> joints(2);
  links[0].name = "base";
  for (int i = 0; i < 2; ++i) {
    links[i + 1].name = "rod_" + std::to_string(i + 1);
    links[i + 1].body = i;
    links[i + 1].inertial.mass = kMass;
    links[i + 1].inertial.com = {0.0, 0.0, -kLength / 2};
    links[i + 1].inertial.inertia = Eigen::Vector3d(kInertia, kInertia, kInertia / 100).asDiagonal();
    joints[i].name = "hinge_" + std::to_string(i + 1);
    joints[i].parent = i - 1;
    joints[i].link = i + 1;
    joints[i].axis = Eigen::Vector3d::UnitY();
  }
  joints[1].origin.translation() = Eigen::Vector3d(0.0, 0.0, -kLength);
  return std::make_shared<const lacuna::Robot>("two_rods", joints, links, "consumer");
}

/// Lagrange's equations of the same rods, solved by Cramer's rule; `q[1]` and `v[1]` are relative to the first rod.
void closed_form(const double* q, const double* v, double* a) {
  const double l = kLength, m = kMass, c = std::cos(q[1]), s = std::sin(q[1]);
  const double m22 = m * l * l / 3, coupling = m * l * l / 2;
  const double m11 = m * l * l * 5 / 3 + 2 * coupling * c, m12 = m22 + coupling * c;
  const double gravity2 = m * kGravity * l / 2 * std::sin(q[0] + q[1]);
  const double gravity1 = gravity2 + m * kGravity * l * 3 / 2 * std::sin(q[0]);
  const double force1 = coupling * s * (2 * v[0] * v[1] + v[1] * v[1]) - gravity1;
  const double force2 = -coupling * s * v[0] * v[0] - gravity2;
  const double determinant = m11 * m22 - m12 * m12;
  a[0] = (m22 * force1 - m12 * force2) / determinant;
  a[1] = (m11 * force2 - m12 * force1) / determinant;
}

}  // namespace

int main() {
  if (lacuna::engines().size() < 2) return std::puts("several engines expected"), 1;

  const auto dynamics = lacuna::find_engine("featherstone").build(two_rods(), {0.0, 0.0, -kGravity});
  const double q[] = {0.4, -1.1}, v[] = {1.3, -0.7}, tau[] = {0.0, 0.0};
  double a[2], expected[2];
  dynamics->forward_dynamics(q, v, tau, a);
  closed_form(q, v, expected);
  std::printf("acceleration %.15g %.15g, closed form %.15g %.15g\n", a[0], a[1], expected[0], expected[1]);

  // A few dozen roundings of numbers of this size.
  constexpr double kTolerance = 1e-12;
  for (int i = 0; i < 2; ++i) {
    if (!(std::abs(a[i] - expected[i]) <= kTolerance * std::abs(expected[i]))) return 1;
  }
  return 0;
}
