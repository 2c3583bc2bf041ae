#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The centre of mass of what a joint moves lies elsewhere than its URDF says. Neutral at zero.
struct ComShift {
  static EffectInfo info() {
    return {"com_shift",
            "Centre of mass shifted",
            Where::joint,
            Stage::link,
            "centre of mass += (dx, dy, dz), frame of the link that the joint moves",
            "gravity and inertia pattern of one link",
            "masses, rest",
            "parallel-axis theorem",
            {{"dx", "m", 0.0, -10.0, 10.0, "shift along x", Scale::length, {0.1}},
             {"dy", "m", 0.0, -10.0, 10.0, "shift along y", Scale::length, {0.1}},
             {"dz", "m", 0.0, -10.0, 10.0, "shift along z", Scale::length, {0.1}}}};
  }
  static void inertials(const double* p, const Robot&, int joint, std::vector<Inertial>& bodies) {
    bodies[joint].com += Eigen::Vector3d(p[0], p[1], p[2]);
  }
};

}  // namespace lacuna
