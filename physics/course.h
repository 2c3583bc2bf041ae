// Commands to move a plant by: courses made of coordinates in [0, 1], the limits they must keep to, and the commands as
// an experiment.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "physics/experiment.h"
#include "physics/plant_model.h"

namespace lacuna {

enum class Shape { multisine, staircase, both };

constexpr double kRestBefore = 0.5;  ///< s at zero command before anything moves

/// One joint's command: a sum of sines spread over the band from one period in the whole motion to `hertz`, or stairs
/// of drawn heights and lengths of at least half a period of `hertz`; `both`: stairs in the first half, sines in the
/// second.
class Courses {
 public:
  Courses(Shape shape, double seconds, double hertz) : shape_(shape), seconds_(seconds), hertz_(hertz) {}

  std::size_t size() const;  ///< coordinates of one joint
  /// `x`: `size()` numbers in [0, 1]. At most `peak`, V, in absolute value.
  std::vector<double> course(std::span<const double> x, const std::vector<double>& time, double peak) const;

 private:
  std::vector<double> sines(std::span<const double> x, const std::vector<double>& time, double from, double to,
                            double peak) const;
  std::vector<double> stairs(std::span<const double> x, const std::vector<double>& time, double from, double to,
                             double peak) const;

  Shape shape_;
  double seconds_, hertz_;
};

/// The commands as a recording holds them: the scenario's columns, offsets and scales.
Recording as_recording(const Scenario& scenario, const CommandTrack& commands);

/// `joints` commands of zero over `seconds`, one sample a period.
CommandTrack still_commands(std::size_t joints, double seconds, double period);

/// What a motion must keep to, one entry a joint. Infinite: no limit.
struct MotionLimits {
  std::vector<double> command;          ///< V, absolute
  std::vector<double> lowest, highest;  ///< position, rad or m
  std::vector<double> speed;            ///< absolute, rad/s or m/s
};
/// Commands as large as the recordings'; positions and speeds that the robot's file allows or the recordings reached.
MotionLimits recorded_limits(const Robot& robot, const Experiment& experiment);

/// The commands as an experiment of one free run with role train, at rest at `start`, measured at 0 throughout.
Experiment commanded(const Experiment& like, const CommandTrack& commands, std::span<const double> start);

/// A simulated motion, as far as it is seen: positions and speeds of joints whose position is measured; NaN elsewhere.
struct SeenMotion {
  bool finite = true;
  double beyond = 0.0;  ///< how far it leaves its limits, relative; 0: it keeps to them
  std::vector<double> lowest, highest, speed;
};
/// `predicted`: [channel][sample] of `segment`.
SeenMotion seen_motion(const Experiment& experiment, const Segment& segment,
                       const std::vector<std::vector<double>>& predicted, const MotionLimits& limits);

}  // namespace lacuna
