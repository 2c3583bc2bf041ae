// One simulator against another: what engine A records by its own stepping and its own losses is diagnosed on engine B,
// and what is found then is told apart. The integrator's part shrinks with A's step; physics does not.
//
//   NativePlant plant = native_plant(scenario, 0.05);
//   Trajectory run = record_natively(plant, one_recording, {"mujoco", "implicit"}, 2e-3);
//   std::vector<SimulatorNumber> numbers = tell_apart(at_step, at_half_step, order);
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/scenario.h"
#include "compare/comparison.h"
#include "compare/runner.h"

namespace lacuna {

/// An engine by its own stepping.
struct NativeMethod {
  std::string engine, integrator;
};

/// A scenario's machine as engine A has it: damping of torque_source and direct_effort and the effect coulomb_friction
/// are the engine's own; everything else drives the joints by efforts held over a step, as a controller's do.
struct NativePlant {
  Scenario scenario;                                  ///< without these, and without effects that only change readings
  std::vector<JointLoss> losses;                      ///< one a joint
  std::vector<std::pair<std::string, double>> given;  ///< what A was built with, by parameter ("joint_2.damping")
};

/// Joints of a scenario that states no coulomb_friction at all get `friction_share` of the gain times the rms command,
/// over its recordings (loaded), wherever the actuator has a gain. Throws InputError for a share below 0.
NativePlant native_plant(const Scenario& scenario, double friction_share);

/// Positions of all joints at the samples of the scenario's only recording, from its start. Throws WorkError where A
/// cannot carry the plant so or the run diverges.
Trajectory record_natively(const NativePlant& plant, const Scenario& one_recording, const NativeMethod& method,
                           double step);

/// How one joint's recorded positions depend on A's step, from runs at h, h/2 and h/4.
struct StepDependence {
  std::string joint, unit;     ///< m or rad
  double order = kUnmeasured;  ///< log2 of the ratio of the two differences; NaN where it is not between .5 and 4
  double error_at_step = 0.0;  ///< rms of the run at h against what Richardson's extrapolation to step 0 gives
  double error_at_half = 0.0;
};
/// `runs[i]`: at h, h/2, h/4, over one recording. Where a joint shows no order it is taken to be 1.
std::vector<StepDependence> step_dependence(const Robot& robot, std::span<const Trajectory> runs);
/// The joints' values together: rms of the errors, the median order (1 where none shows any).
std::vector<StepDependence> pooled(std::span<const std::vector<StepDependence>> recordings);

/// One number of a diagnosis on engine B.
struct FoundNumber {
  std::string name, unit;  ///< "joint_2.gain", "joint_2.coulomb_friction.Fc"
  double value = 0.0;
  double half_width = 0.0;  ///< of the 95 % interval
};
/// What was found on the recordings that A made at one step.
struct SimulatorSide {
  double step = 0.0;  ///< s
  std::string verdict;
  std::vector<FoundNumber> numbers;
  struct Effect {
    std::string effect, place;
    double probability = 0.0;
  };
  std::vector<Effect> effects;
  std::vector<std::pair<std::string, double>> before, after;  ///< residual rms by joint, test or validate recordings
};

enum class Origin { as_built, integrator, physics, both };
const char* to_string(Origin origin);

/// A number at A's step, at half of it, and extrapolated to none.
struct SimulatorNumber {
  std::string name, unit;
  double given = kUnmeasured;                          ///< what A was built with; NaN: nothing like it
  double at_step = 0.0, at_half = 0.0, at_zero = 0.0;  ///< 0 where the number's effect was not found
  double uncertainty = 0.0;                            ///< of `at_step`, half of its 95 % interval
  double integrator = 0.0;                             ///< at_step - at_zero
  double physics = kUnmeasured;                        ///< at_zero - given
  Origin origin = Origin::as_built;
};
/// A part counts where it exceeds its 95 % interval; the extrapolation's is that of `at_step` and `at_half` carried
/// through. Numbers of an effect that only one side has count as 0 on the other. `given`: as of NativePlant; the
/// leading numbers of other effects were given 0.
std::vector<SimulatorNumber> tell_apart(const SimulatorSide& step, const SimulatorSide& half,
                                        std::span<const std::pair<std::string, double>> given, double order);

/// What remains beyond the noise at a joint, at both steps.
struct SimulatorRest {
  std::string joint, unit;
  double noise = 0.0;
  double before = 0.0, at_step = 0.0, at_half = 0.0;  ///< residual rms: plain model at h, found model at h and h/2
  Origin origin = Origin::as_built;
};
/// Of the energy beyond the noise: `integrator` where at most half of it is left at half the step (a quarter would be
/// of first order), `physics` where at least .8 are, `both` between; `as_built` where both rms are within a tenth of
/// the noise.
Origin origin_of_rest(double noise, double at_step, double at_half);

/// The whole comparison, as it is written.
struct SimulatorComparison {
  std::string scenario, other;  ///< other: engine B
  NativeMethod method;          ///< of engine A
  double step = 0.0;            ///< s
  std::vector<std::string> joints;
  std::vector<JointLoss> losses;
  std::vector<StepDependence> steps;
  double order = 1.0;
  SimulatorSide at_step, at_half;
  std::vector<SimulatorNumber> numbers;
  std::vector<SimulatorRest> rests;
  std::vector<std::string> notes;
  double seconds = 0.0;
};

}  // namespace lacuna
