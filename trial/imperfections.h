// What makes a true machine unlike any model, beside the physics that is hidden in it. Real machines have all of it: a
// motion that nobody can explain, laws that are not quite the textbook's, numbers that change from day to day, a URDF
// that is a little wrong; and recordings that are short, or in which one joint alone is driven.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ga/random.h"
#include "physics/experiment.h"
#include "physics/outside.h"
#include "physics/plant_model.h"
#include "trial/hidden_effect.h"
#include "trial/outside_case.h"

namespace lacuna {

/// As `lacuna conceal --help` describes them; each is nothing as it stands here.
struct Imperfections {
  double background = 0.0;    ///< rms over noise that a plain refit leaves of a ripple and a slow push at every joint
  double uneven = 0.0;        ///< share, below 1, by which a hidden law's strength changes along its way, at most
  double drift = 0.0;         ///< share, below 1, by which it differs between recordings, at most
  double misplaced = 0.0;     ///< m, by which each centre of mass lies off along each axis, at most
  double seconds = HUGE_VAL;  ///< how long recordings are, at most
  std::string alone;          ///< the one joint that is commanded; empty: all that are
};

/// The scenario with recordings that are so short and commands that hold all joints but one. Throws InputError for a
/// joint that it does not have or does not command.
Scenario shortened(const Scenario& scenario, const Imperfections& imperfections);

/// Strength 1 + share sin(2 pi (x - centre) / width) of its mean, as UnevenParameter.
struct UnevenLaw {
  bool over_command = false;
  double share = 0.0, centre = 0.0, width = 1.0;  ///< rad (m), or the command's unit
};
/// Drawn within the travel: half to one and a half periods in it. A joint or a command that never moves has an even
/// law.
UnevenLaw drawn_unevenness(double share, int joint, Stage stage, const Travel& travel, RandomStream stream);

/// Centres of mass off by up to `most` (m) along each axis of each link that moves, drawn: an effect `com_shift` at
/// each joint at which neither the plain plant nor `hidden` has one.
std::vector<EffectSpec> misplaced_centres(double most, const PlantModel& plain, std::span<const HiddenEffect> hidden,
                                          std::uint64_t seed);

/// A ripple over each joint's travel and a slow push on it, other in every recording: three sines with periods of 2 to
/// 20 s. Neither is a law of the catalogue, and no law of the joint's motion describes the push.
class Background {
 public:
  Background() = default;
  /// Ripple and push of a joint of rms `sizes` (N m or N).
  Background(std::span<const double> sizes, const Travel& travel, std::uint64_t seed);
  bool none() const { return ripples_.empty(); }
  std::size_t joints() const { return ripples_.size(); }
  void scale(std::size_t joint, double factor);
  Background only(std::size_t joint) const;
  Background times(double factor) const;
  /// Puts the pushes into the segment and the ripples to what else acts.
  void act(Segment& segment, std::vector<OutsidePhysics>& outside) const;

 private:
  double push(std::size_t joint, int recording, double t) const;  ///< rms 1

  std::vector<OutsidePhysics> ripples_;
  std::vector<double> pushes_;  ///< N m or N, rms
  std::uint64_t seed_ = 0;
};

}  // namespace lacuna
