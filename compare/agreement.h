// How far an engine's accelerations and poses are from Featherstone's, over random states.
#pragma once

#include <cstdint>

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/motion.h"

namespace lacuna {

/// States that an agreement is stated over.
inline constexpr int kAgreementStates = 1024;

/// One state: angles within the joint's limits, else within +-pi (slides within 0.5 m); speeds within 2 rad/s (m/s);
/// efforts within 20 N m (N).
struct RandomState {
  std::vector<double> q, v, tau;
};
RandomState random_state(const Robot& robot, std::uint64_t seed, int index);

/// Fills the engine's acceleration_difference, acceleration_error, pose_difference and states, under the parameters of
/// the motion's first phase. Throws WorkError where the engine cannot hold the robot.
void measure_agreement(const Motion& motion, std::uint64_t seed, int threads, const StopFlag* stop,
                       EngineComparison& out, int states = kAgreementStates);

}  // namespace lacuna
