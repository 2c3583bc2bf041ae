#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A point mass held at the tool (Robot::tool) or beside it, possibly in some recordings only. Neutral at m = 0.
struct Payload {
  static EffectInfo info() {
    EffectInfo info{"payload",
                    "Payload",
                    Where::arm,
                    Stage::link,
                    "point mass m at the tool's origin + (x, y, z), axes of the body that carries the tool",
                    "gravity and inertia of the outer joints grow",
                    "link masses",
                    "point mass, parallel-axis theorem",
                    {{"m", "kg", 0.0, 0.0, 1e5, "carried mass", Scale::mass, {0.02}},
                     offset("x", "place beyond the tool's origin along x"),
                     offset("y", "place beyond the tool's origin along y"),
                     offset("z", "place beyond the tool's origin along z")}};
    info.per_recording = true;
    return info;
  }
  static void inertials(const double* p, const Robot& robot, int, std::vector<Inertial>& bodies) {
    if (p[kM] == 0.0) return;
    Inertial& carrier = bodies[robot.tool().body];
    const Eigen::Vector3d place = robot.tool().point + Eigen::Vector3d(p[kX], p[kY], p[kZ]);
    carrier = welded(carrier, {p[kM], place, Eigen::Matrix3d::Zero()});
  }

 private:
  enum { kM, kX, kY, kZ };
  static ParameterInfo offset(const char* name, const char* meaning) {
    ParameterInfo info{name, "m", 0.0, -10.0, 10.0, meaning, Scale::length, {0.1}};
    info.optional = true;
    return info;
  }
};

}  // namespace lacuna
