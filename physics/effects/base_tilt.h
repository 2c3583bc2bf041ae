#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The base does not stand level: gravity turns in its frame. Neutral at zero.
struct BaseTilt {
  static EffectInfo info() {
    return {"base_tilt",
            "Base tilt",
            Where::arm,
            Stage::link,
            "gravity turned by roll about x, then pitch about y, of the base",
            "a constant torque pattern over all joints; shows on joints that are vertical otherwise",
            "valve_offset, rest",
            "rotation of the base frame",
            {{"roll", "rad", 0.0, -3.2, 3.2, "about x", Scale::ratio, {0.01}},
             {"pitch", "rad", 0.0, -3.2, 3.2, "about y", Scale::ratio, {0.01}}}};
  }
  static Eigen::Vector3d gravity(const double* p, const Eigen::Vector3d& plain) {
    return Eigen::AngleAxisd(-p[0], Eigen::Vector3d::UnitX()) *
           (Eigen::AngleAxisd(-p[1], Eigen::Vector3d::UnitY()) * plain);
  }
};

}  // namespace lacuna
