// Random trees and random states, the same on every machine for one seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/reference/robots.h"

namespace lacuna::test {

/// Numbers from a Mersenne twister, mapped here: the standard's distributions differ between libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
  int below(int n) { return static_cast<int>(bits_() % static_cast<std::uint64_t>(n)); }
  Eigen::Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Eigen::Vector3d direction() {
    for (;;) {
      const Eigen::Vector3d v = vector(1.0);
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  }
  Eigen::Matrix3d rotation() {
    return Eigen::AngleAxisd(uniform(-std::numbers::pi, std::numbers::pi), direction()).toRotationMatrix();
  }
  std::vector<double> numbers(int n, double size) {
    std::vector<double> out(n);
    for (double& x : out) x = uniform(-size, size);
    return out;
  }

 private:
  std::mt19937_64 bits_;
};

/// Any inertia of real matter: principal moments b+c, a+c, a+b from second moments a, b, c > 0, axes anywhere.
inline Inertial random_inertial(Random& random) {
  Inertial out;
  out.mass = std::exp(random.uniform(std::log(0.3), std::log(5.0)));
  out.com = random.vector(0.2);
  Eigen::Vector3d second;
  for (double& moment : second) moment = out.mass * std::pow(random.uniform(0.05, 0.2), 2);
  const Eigen::Vector3d principal(second.y() + second.z(), second.x() + second.z(), second.x() + second.y());
  const Eigen::Matrix3d axes = random.rotation();
  out.inertia = axes * principal.asDiagonal() * axes.transpose();
  out.inertia = (0.5 * (out.inertia + out.inertia.transpose())).eval();
  return out;
}

/// Parents anywhere before the child, or the world; three joints in ten slide.
inline std::vector<BodySpec> random_bodies(Random& random, int n) {
  std::vector<BodySpec> bodies(n);
  for (int i = 0; i < n; ++i) {
    BodySpec& body = bodies[i];
    // Half the bodies extend the chain, so that long branches occur.
    body.parent = random.uniform(0, 1) < 0.5 ? i - 1 : random.below(i + 1) - 1;
    body.type = random.uniform(0, 1) < 0.3 ? JointType::prismatic : JointType::revolute;
    body.axis = random.direction();
    body.origin.linear() = random.rotation();
    body.origin.translation() = random.vector(0.5);
    body.inertial = random_inertial(random);
  }
  return bodies;
}

inline std::shared_ptr<const Robot> random_tree(std::uint64_t seed, int n) {
  Random random(seed);
  return make_robot("random tree of " + std::to_string(n) + ", seed " + std::to_string(seed), random_bodies(random, n));
}

struct State {
  std::vector<double> q, v, tau;
};

/// Angles all round, slides within half a metre; rates of a brisk arm, efforts of some tens.
inline State random_state(Random& random, const Robot& robot) {
  State state{random.numbers(robot.dof(), std::numbers::pi), random.numbers(robot.dof(), 2.0),
              random.numbers(robot.dof(), 20.0)};
  for (std::size_t i = 0; i < state.q.size(); ++i) {
    if (robot.joints()[i].prismatic()) state.q[i] *= 0.5 / std::numbers::pi;
  }
  return state;
}

}  // namespace lacuna::test
