// Where the plain model fails: the effort that would explain the residual, joint by joint.
//
// A disturbance at one joint shakes its neighbours, so the largest error of position is often at another joint than its
// cause. The effort that the measured motion needs beyond what the model gives (inverse dynamics of the low-passed
// motion) stands at the joint itself. What filter and held commands leave of a motion without any mismatch is taken off
// by doing the same to the model's own free run. Noise: that of the positions, sent through the same computation, as
// slow as its high-frequency content says (first order).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "physics/simulator.h"

namespace lacuna {

struct CurrentModel;
struct LearnedLaw;

constexpr double kLocateCutoff = 4.0;      ///< Hz
constexpr double kLocateError = 1e-3;      ///< of one false statement in a diagnosis, for each kind of statement
constexpr double kLeastCorrelation = 0.2;  ///< that is worth mentioning

/// The missing effort is larger there than elsewhere.
struct RegionTest {
  std::string region;  ///< in words
  double ratio = 1.0;  ///< mean square there over mean square elsewhere
  double p_value = 1.0;
};
/// The missing effort goes with a quantity.
struct FollowsTest {
  std::string quantity;  ///< in words
  double correlation = 0.0;
  double p_value = 1.0;
};

/// The missing effort changes in power, beyond chance.
struct EffortChange {
  std::string recording;
  double time = 0.0;                 ///< s
  double before = 0.0, after = 0.0;  ///< rms from the change before to it, and from it to the next
  double p_value = 1.0;
};

/// One joint's missing effort, in the unit of its command (an effort over the actuator's gain).
struct MissingEffort {
  std::string joint, unit;
  double rms = 0.0, noise = 0.0;
  double share = 0.0;                 ///< of what stands above the noise at all joints, in units of the noise
  double p_value = 1.0;               ///< of so much from noise alone, corrected for the joints
  std::vector<RegionTest> regions;    ///< beyond chance, largest ratio first
  std::vector<FollowsTest> follows;   ///< beyond chance, strongest first
  std::vector<EffortChange> changes;  ///< in the session's order
  std::string recording;              ///< of the trace:
  std::vector<double> time, trace;    ///< s, and the effort
};

/// What a learned law of an effort stands for, over its first variable: the effort that the measured motion needs
/// beyond the model with the law, sample by sample, and the law's own on top; N m (N). Empty where inverse dynamics
/// cannot be had, or where the joint's command is no effort and none was measured. Of train and validate recordings.
std::vector<std::pair<double, double>> cloud_of(const LearnedLaw& law, const CurrentModel& with_law,
                                                const Scenario& scenario, const SimulatorOptions& options);

/// Joints at which something may be missing: beyond the noise and at least `kLikely` of it all. Empty: any.
constexpr double kLikely = 0.01;
std::vector<std::string> likely_joints(const std::vector<MissingEffort>& missing);

/// Whether inverse dynamics of its recordings can be had at kLocateCutoff: every joint's position is measured, long and
/// often enough.
bool can_invert(const Experiment& simulated);

/// All joints, largest share first; empty where inverse dynamics cannot be had: a joint's position is not measured, its
/// noise is unknown, a recording is shorter than ten cycles of the cutoff, or the cutoff is beyond the sampling. Reads
/// train and validate recordings. p-values are corrected (Bonferroni) for joints times regions, joints times
/// quantities, joints times possible changes.
std::vector<MissingEffort> missing_efforts(const CurrentModel& model, const Scenario& scenario,
                                           const SimulatorOptions& options, std::uint64_t seed);

/// One joint's missing effort in one recording, sample by sample; in the unit of its command.
struct EffortCourse {
  std::string recording, joint;
  std::vector<double> time, effort;  ///< s, and the effort
};
/// To be looked at, test recordings included: nothing may be decided by it. Of the recordings named, in the scenario's
/// order; empty where missing_efforts is.
std::vector<EffortCourse> effort_courses(const CurrentModel& model, const Scenario& scenario,
                                         const SimulatorOptions& options, const std::vector<std::string>& recordings);

}  // namespace lacuna
