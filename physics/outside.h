// Physics outside the catalogue, for cases in which naming nothing is right and describing it is what is asked: laws of
// a joint's motion or command, and things that happen at certain times.
//
// Added to a plant only by its true machine (truth.h). Only the kinds are written here; the numbers of their form are
// drawn where a case is made, so that nobody who writes a diagnosis has chosen them.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "physics/stage.h"

namespace lacuna {

struct OutsidePhysics {
  enum class Kind {
    position_ripple,        ///< effort += s sin(2 pi (q - centre) / width): cogging
    external_push,          ///< effort += s, as half sines of kPushLasts: somebody leans on the link
    command_dropout,        ///< the command is 0 for s seconds
    counterbalance_spring,  ///< effort += s (1 - length / l) sin(theta), theta = q - centre, between two levers
    tight_spot,             ///< effort -= s exp(-((q - centre) / width)^2), against the motion: friction at one place
    valve_notch,            ///< u - s exp(-((u - centre) / width)^2) arrives instead of u
    cable_drag,             ///< effort += s tanh((q of another joint - centre) / width): a cable over both pulls
    repeated_samples        ///< the position's transducer repeats its last sample for s seconds
  };
  Kind kind = Kind::position_ripple;
  int joint = 0;
  double strength = 0.0;  ///< s: N m (N); valve_notch: the command's unit; command_dropout, repeated_samples: s
  /// s from the start, per recording of the scenario: when pushes, dropouts and repeats begin.
  std::vector<std::vector<double>> times = {};

  /// A law's form. Centre and width in the unit of what the law goes over: rad (m), or the command's.
  struct Form {
    double centre = 0.0;                           ///< of counterbalance_spring where it pulls straight
    double width = 2.0 * std::numbers::pi / 24.0;  ///< of position_ripple its period
    double lever = 0.0;                            ///< of counterbalance_spring, over the base's: of the link's side
    double length = 0.0;                           ///< of counterbalance_spring, over the base's lever: unstretched
    double slow = 0.0;                             ///< of tight_spot: rad/s (m/s) below which it fades with the speed
    int other = -1;                                ///< of cable_drag: the joint that it goes over
  };
  Form form = {};
};

constexpr double kPushLasts = 0.4;  ///< s

/// What a law goes over.
enum class OutsideWay { position, position_and_direction, other_position, command, time };

struct OutsideInfo {
  OutsidePhysics::Kind kind;
  const char* name;  ///< as in labels
  Stage stage;
  OutsideWay over;
};
/// In the order of the kinds.
const std::vector<OutsideInfo>& outside_table();
const OutsideInfo& info_of(OutsidePhysics::Kind kind);
/// Empty for a name that is none of them.
std::optional<OutsidePhysics::Kind> outside_physics_named(const std::string& name);
const char* to_string(OutsidePhysics::Kind kind);
std::vector<std::string> outside_physics_names();

/// s that one of the things that happen lasts.
double seconds_of(const OutsidePhysics& physics);

/// What a law adds at `x` of what it goes over, N m (N) or of the command's unit; `direction` of the motion, from -1 to
/// 1, where it goes over that, too. Nothing for what happens at certain times.
template <class T>
T outside_law(const OutsidePhysics& physics, const T& x, const T& direction = T(1.0)) {
  const OutsidePhysics::Form& form = physics.form;
  const T off = x - form.centre, share = off / form.width;
  switch (physics.kind) {
    case OutsidePhysics::Kind::position_ripple:
      return physics.strength * std::sin(T(2.0) * std::numbers::pi_v<T> * share);
    case OutsidePhysics::Kind::counterbalance_spring: {
      const T spring = std::sqrt(T(1.0) + form.lever * form.lever - T(2.0) * form.lever * std::cos(off));
      return physics.strength * (T(1.0) - form.length / spring) * std::sin(off);
    }
    case OutsidePhysics::Kind::tight_spot: return -physics.strength * std::exp(-share * share) * direction;
    case OutsidePhysics::Kind::valve_notch: return -physics.strength * std::exp(-share * share);
    case OutsidePhysics::Kind::cable_drag: return physics.strength * std::tanh(share);
    case OutsidePhysics::Kind::external_push:
    case OutsidePhysics::Kind::command_dropout:
    case OutsidePhysics::Kind::repeated_samples: break;
  }
  return T(0.0);
}

/// `values` less the constant and the part linear in each column of `at` (one row a value), by least squares: what is
/// left of a law when the plain parameters have taken up what they can.
std::vector<double> beyond_linear(const std::vector<std::vector<double>>& at, std::vector<double> values);
double root_mean_square(const std::vector<double>& values);

/// What a label says of physics outside the catalogue, and a diagnosis of what it learned: a curve, or events.
struct LawRecord {
  struct Point {
    std::vector<double> at;  ///< one number for each of `over`
    double value = 0.0;
  };
  struct Event {
    std::string recording;
    double from = 0.0, to = 0.0;  ///< s, on the recording's own clock
    std::optional<double> value;  ///< N m (N), or what the command was; nothing for repeated samples
  };
  std::string stage;
  std::vector<std::string> over;
  std::vector<Point> curve;
  std::vector<Event> events;
};

}  // namespace lacuna
