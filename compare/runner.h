// One engine carried through a motion by one method.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "physics/executor.h"
#include "compare/motion.h"

namespace lacuna {

/// States at the motion's samples (Motion::times) and what they took. A run that diverged holds numbers that are not
/// finite from there on.
struct Trajectory {
  std::vector<std::vector<double>> q, v;  ///< [sample][joint], rad (m), rad/s (m/s)
  double seconds = 0.0;                   ///< CPU time, building the engine left out
  long steps = 0;                         ///< taken; of a method with step control the dynamics' evaluations
};

/// The method that is the same for all engines at a fixed step: the rollout's, Kutta's of fourth order
/// (physics/rollout.h).
inline constexpr char kCommonMethod[] = "rk4";
/// The same for all at a tolerance: Dormand and Prince's pair of orders 5 and 4 with step control (physics/truth.h).
inline constexpr char kAdaptiveMethod[] = "dopri5";

/// A method of one engine; `native` separates the engine's own "rk4" from the common one.
struct Method {
  std::string name;
  bool native = false;
};
/// The common ones, then the engine's own, its default first.
std::vector<Method> methods_of(const std::string& engine);

/// Not shared between threads.
class Runner {
 public:
  /// Builds the engine. Throws WorkError where it is not available or cannot hold the robot.
  Runner(std::string engine, const Motion& motion);
  ~Runner();

  /// What the engine's own methods take away by the engine's own model of losses (backends/engine.h), one a joint.
  /// Throws WorkError where it has none.
  void set_own_losses(std::span<const JointLoss> losses);

  /// Why this engine cannot be carried through this motion by the method; "" where it can.
  std::string refuses(const Method& method) const;

  /// Steps of at most `step` s that end at the samples. The engine's own methods take what drives the joints at the
  /// start of a step and hold it, as a controller does; states of the plant go along by Euler's method.
  Trajectory run(const Method& method, double step);
  /// By kAdaptiveMethod. One engine is built for each call.
  Trajectory run_adaptive(double tolerance, const StopFlag* stop) const;

 private:
  struct Plants;
  std::string engine_;
  const Motion& motion_;
  std::unique_ptr<Plants> plants_;
};

/// By the referee's method, without any engine (physics/truth.h, extended precision). Throws WorkError, Interrupted.
Trajectory run_referee(const Motion& motion, double tolerance, double memory_step, const StopFlag* stop);

}  // namespace lacuna
