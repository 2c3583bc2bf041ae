// Command sequences: what they would tell of the parameters, and which ones tell most.
//
// Information is that of the whitened sensitivities (Fisher's, residuals over their noise). Where data leave directions
// open, the determinant alone is zero for every motion; so each parameter is given the variance of its bounds (uniform:
// width^2 / 12) beforehand, and the determinant of the sum is maximised. Source: K. Chaloner, I. Verdinelli, Bayesian
// experimental design: a review, Stat. Sci. 10 (1995), sec. 2.2.
#pragma once

#include <string>
#include <vector>

#include "physics/course.h"
#include "study/identifiability.h"

namespace lacuna {

const char* to_string(Shape shape);
/// Throws std::invalid_argument naming the known ones.
Shape shape_from_name(const std::string& name);

/// Limits of the recordings (physics/course.h). `command`, `reach`, `speed`: further limits of every joint (reach:
/// distance from the start position); NaN: none.
MotionLimits motion_limits(const Trial& trial, double command, double reach, double speed);

struct DesignOptions {
  Shape shape = Shape::both;
  double seconds = 20.0;  ///< length of the motion
  double hertz = 3.0;     ///< highest frequency of a multisine; the shortest stair lasts half its period
  int population = 24, generations = 40;
  std::uint64_t seed = 1;
  int threads = 1;
  RunControl control;
};

/// One motion and what it tells.
struct Design {
  std::string name;
  CommandTrack commands;
  double log_det = 0.0;                 ///< of information plus prior, coordinates in units of their prior's deviation
  Excitation excitation;                ///< what it determines
  std::vector<double> peak_command;     ///< V, per joint
  std::vector<double> peak_speed;       ///< rad/s or m/s
  std::vector<double> lowest, highest;  ///< positions reached
};

struct DesignResult {
  Design best;
  Design step;  ///< the paper's excitation: one step of every actuated joint, as large as the limits allow
  std::vector<Design> recordings;  ///< the commands of the scenario's own train recordings
  long evaluations = 0;            ///< motions looked at
  std::vector<GenerationRecord> history;
};

/// Designs a motion at the scenario's present parameter values. Throws InputError where nothing is commanded or
/// measured, WorkError where no motion keeps to the limits.
DesignResult design_excitation(const Trial& trial, const MotionLimits& limits, const DesignOptions& options);

}  // namespace lacuna
