#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A point mass held at the tool (Robot::tool), possibly in some recordings only.
struct Payload {
  static EffectInfo info() {
    EffectInfo info{"payload",
                    "Payload",
                    Where::arm,
                    "point mass m at the tool",
                    "gravity and inertia of the outer joints grow",
                    "link masses",
                    "point mass, parallel-axis theorem",
                    {{"m", "kg", 0.0, 0.0, 1e5, "carried mass", Scale::mass, {0.02}}}};
    info.per_recording = true;
    return info;
  }
  static void inertials(const double* p, const Robot& robot, int, std::vector<Inertial>& bodies) {
    if (p[0] == 0.0) return;
    Inertial& carrier = bodies[static_cast<std::size_t>(robot.tool().body)];
    carrier = welded(carrier, {p[0], robot.tool().point, Eigen::Matrix3d::Zero()});
  }
};

}  // namespace lacuna
