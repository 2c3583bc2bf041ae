// The result of a comparison: plain numbers, filled by the measurements of this room, written by reports/.
//
// A number that was not measured is NaN, and a word beside it says why. Positions of sliding joints are metres, of
// others radians; an error "over the joints" is the largest, each in its own unit.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "backends/engine.h"
#include "compare/runner.h"

namespace lacuna {

inline constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();

/// The larger one; not-a-number is the worst and stays.
double worse(double a, double b);

/// Repeated timings, interleaved with those they are compared with.
struct Timing {
  double median = kUnmeasured;
  double low = kUnmeasured, high = kUnmeasured;  ///< quartiles
  int repeats = 0;
};
Timing timing_of(std::vector<double> values);

/// A worst value and where it was seen.
struct WorstSeen {
  double value = kUnmeasured;
  std::string where;
  /// Not-a-number counts as infinitely bad.
  void see(double candidate, const std::string& at);
};

/// One run of one method on one engine.
struct WorkPoint {
  double step = kUnmeasured;              ///< s; NaN where the method chooses its own
  double tolerance = kUnmeasured;         ///< of a method that chooses its step
  double error = kUnmeasured;             ///< worst position error over joints and time
  double steps_per_second = kUnmeasured;  ///< of motion; of a method with step control evaluations
  double cpu_per_second = kUnmeasured;    ///< s of computing per s of motion: steps times what one costs
  bool stable = false;                    ///< stayed finite and within bounds
};

/// How an engine is carried through time: by its own integrator, or by one that is the same for all engines.
struct MethodResult {
  std::string name;  ///< "rk4", "dopri5", or the engine's own name for it
  bool native = false;
  bool adaptive() const { return name == kAdaptiveMethod && !native; }  ///< chooses its own steps
  std::string not_run;                                                  ///< why nothing was measured; else empty
  std::vector<WorkPoint> points;                                        ///< from long steps to short ones
  double order = kUnmeasured;       ///< slope of log error over log step where neither coarseness nor rounding rules
  double order_free = kUnmeasured;  ///< the same in free motion, where nothing is held over a step
  double largest_stable_step = kUnmeasured;  ///< s, of the steps tried
  bool stable_at_longest = false;            ///< even the longest step tried
  // At the comparison's own step, over the whole motion:
  double trajectory_seconds = kUnmeasured;  ///< s, of the motion that was run: less than all where that takes too long
  double trajectory_error = kUnmeasured, trajectory_error_rms = kUnmeasured;
  double trajectory_worst_time = kUnmeasured;  ///< s
  std::string trajectory_worst_joint;
  std::vector<double> time, error;      ///< s; worst over the joints
  double energy_drift = kUnmeasured;    ///< free motion: largest change over the largest kinetic energy
  double momentum_drift = kUnmeasured;  ///< the same without gravity: of the root joint's momentum
  Timing ns_per_step;
  double realtime_factor = kUnmeasured;  ///< s of motion per s of computing
  bool repeats = false;                  ///< a second run gives the same bits
  bool restores = false;                 ///< a run resumed from a saved (q, v) on a fresh build gives the same bits
};

/// Joints coming apart, where an engine keeps bodies and not joint angles.
struct JointDrift {
  std::string settings;           ///< "step, ERP 0.2"
  double distance = kUnmeasured;  ///< m, between the two bodies' idea of where their joint is
  double angle = kUnmeasured;     ///< rad, between their ideas of its axis
};

struct EngineComparison {
  std::string engine, version;
  bool available = false;
  std::string reason;  ///< why nothing was measured: not built, or the engine cannot hold the robot

  WorstSeen acceleration_difference;  ///< |a - a_featherstone| / |a_featherstone| over random states
  WorstSeen acceleration_error;       ///< the same against Featherstone in extended precision
  WorstSeen pose_difference;          ///< m and rotation-matrix entries, against Featherstone
  int states = 0;

  Timing forward_ns, set_inertial_ns, build_us;
  double memory_bytes = kUnmeasured;
  std::vector<JointDrift> joint_drift;
  std::vector<MethodResult> methods;  ///< the common ones first
  bool has_method(const std::string& name) const;
  const MethodResult& method(const std::string& name) const;  ///< throws std::out_of_range
};

/// Parameters of one engine's data found on another engine.
struct PairFit {
  std::string data_engine, engine;
  std::vector<std::pair<std::string, double>> values;
  double parameter_error = kUnmeasured;  ///< largest |found / true - 1|
  double output_rms = kUnmeasured;       ///< of the residual over the noise weight, over all joints
  long evaluations = 0;
  double seconds = 0.0;
};

struct PairFits {
  std::string not_run;  ///< why, where there is none
  std::vector<std::pair<std::string, double>> truth;
  std::string budget;     ///< in words
  double duration = 0.0;  ///< s of data
  double weight = 0.0;    ///< rad (m), rms that residuals are weighed by
  std::vector<PairFit> pairs;
};

struct RefereeRecord {
  std::string method;                  ///< in words
  double tolerance = kUnmeasured;      ///< of the tighter of two runs
  double error = kUnmeasured;          ///< largest difference between the two within `trusted_until`
  double trusted_until = kUnmeasured;  ///< s: until here the two differ by less than is asked of a referee
  double seconds = 0.0;
};

struct ScenarioComparison {
  std::string name, file, motion;  ///< the motion in words
  int dof = 0;
  double duration = 0.0;  ///< s
  double step = 0.0;      ///< s, of the common figures
  double window = 0.0;    ///< s, over which steps are varied
  bool commanded = false;
  RefereeRecord referee;
  std::vector<EngineComparison> engines;
  PairFits identification;
  std::vector<std::string> notes;  ///< what was left out, in words
  double seconds = 0.0;

  const EngineComparison* find(const std::string& engine) const;
};

struct Comparison {
  std::vector<ScenarioComparison> scenarios;
  std::vector<EngineInfo> engines;  ///< all that Lacuna knows, built in or not
  double seconds = 0.0;
};

}  // namespace lacuna
