// The converged reference that engines are held against, outside all of them.
#pragma once

#include "physics/executor.h"
#include "compare/comparison.h"
#include "compare/motion.h"
#include "compare/runner.h"

namespace lacuna {

/// Two runs of differing tolerance count as the same motion while they differ by less, rad (m).
inline constexpr double kTrusted = 1e-9;
/// The same for plants with memories, which are carried by steps of a fixed length.
inline constexpr double kTrustedWithMemories = 1e-6;

struct Referee {
  Trajectory reference;       ///< the tighter run
  std::vector<double> times;  ///< s, of its samples
  std::size_t trusted = 0;    ///< samples, from the first, in which the two runs agree
  double top_speed = 0.0;     ///< rad/s (m/s), of any joint
  RefereeRecord record;
};

/// Runs the motion at two tolerances, two decades apart: their difference bounds the looser one's error, hence the
/// tighter one's. Throws WorkError where the motion diverges, Interrupted.
Referee make_referee(const Motion& motion, int threads, const StopFlag* stop);

/// How far a run is from the referee.
struct ErrorSeries {
  std::vector<double> error;  ///< at each trusted sample, the worst joint's, rad (m)
  double worst = kUnmeasured, worst_time = kUnmeasured, rms = kUnmeasured;
  int worst_joint = 0;
  bool stable = false;  ///< finite, and no joint faster than ten times the reference's fastest
};
ErrorSeries error_of(const Trajectory& run, const Referee& referee);

}  // namespace lacuna
