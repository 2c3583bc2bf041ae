// A joint's speed against its command, read off the recordings: of a drive whose valve gives a flow, the whole of what
// its command does to it as long as no load slows it down.
//
// Over a short while a position changes by the integral of f(u(t - delay)), smoothed by a lag, f any function. With f
// by straight lines between knots that is linear in its values there, and least squares over all such whiles has them;
// the delay and the lag are searched. Nobody's law of a valve is in it, so it is also the yardstick of one: a diagnosis
// that predicts worse than this map has no use. The method is that of a Hammerstein model's static part (K. S.
// Narendra, P. G. Gallman, IEEE Trans. Automatic Control 11 (1966)).
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "physics/experiment.h"
#include "physics/plant_model.h"

namespace lacuna {

struct ValveChart {
  int joint = 0;
  std::string name;               ///< of the joint
  double delay = 0.0, lag = 0.0;  ///< s
  std::vector<double> command;    ///< knots, evenly spaced, in the command's unit
  std::vector<double> speed;      ///< rad/s (m/s) there
  std::vector<double> seen;       ///< s, for how long the train recordings command about as much
  /// rad (m): where the joint stands against its drive at either end of its travel; infinite: it does not.
  std::array<double, 2> stops{-HUGE_VAL, HUGE_VAL};
  /// rad (m), rms of what the chart leaves of the positions that are predicted, by role of the recordings.
  std::vector<std::pair<Role, double>> rms;

  /// What speeds f at the knots would leave over all whiles, rad^2 (m^2): energy + |root^T f - target|^2.
  Eigen::MatrixXd root;
  Eigen::VectorXd target;
  double energy = 0.0;
};

/// One a joint that an integrating drive moves, that is commanded and whose position is predicted, on the train
/// recordings; none in inverse dynamics. `delay`, `lag`: whether they are searched; else they are 0.
std::vector<ValveChart> valve_charts(const PlantModel& model, const Experiment& experiment);
ValveChart valve_chart(const Experiment& experiment, int joint, bool delay, bool lag);

}  // namespace lacuna
