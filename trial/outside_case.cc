#include "trial/outside_case.h"

#include <algorithm>
#include <cmath>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using Kind = OutsidePhysics::Kind;
using Form = OutsidePhysics::Form;
using Range = Travel::Range;

constexpr int kCurvePoints = 60;  // of a label's curve, each way
constexpr int kSpringDraws = 200;
constexpr double kSameInstant = 1e-9;  // s
constexpr double kBent = 0.15;         // of a spring's curve: the least share that no line takes up
constexpr double kSlowShare = 0.02;    // of the rms speed: below it friction at a tight spot fades

std::vector<double> spread(const Range& range) {
  std::vector<double> out(kCurvePoints);
  for (int k = 0; k < kCurvePoints; ++k) out[k] = range.at(k / (kCurvePoints - 1.0));
  return out;
}

double uniform_in(const Range& range, double from, double to, RandomStream& stream) {
  return range.at(stream.uniform(from, to));
}

double bent_share(const Form& form, const Range& travel) {
  const OutsidePhysics spring{Kind::counterbalance_spring, 0, 1.0, {}, form};
  std::vector<std::vector<double>> at;
  std::vector<double> values;
  for (const double q : spread(travel)) {
    at.push_back({q});
    values.push_back(outside_law(spring, q));
  }
  return root_mean_square(beyond_linear(at, values)) / root_mean_square(values);
}

/// The first draw that is not nearly a line within the travel, which a plain spring would take up; else the most bent.
Form drawn_spring(const Range& travel, RandomStream& stream) {
  Form out;
  double most = -1.0;
  for (int k = 0; k < kSpringDraws && most < kBent; ++k) {
    Form form;
    form.lever = stream.uniform(0.3, 0.8);
    form.length = stream.uniform(0.2, 0.6);
    form.centre = travel.at(0.5) + stream.uniform(-std::numbers::pi, std::numbers::pi);
    const double share = bent_share(form, travel);
    if (share > most) most = share, out = form;
  }
  return out;
}

Form drawn_notch(const Range& commands, RandomStream& stream) {
  const double largest = std::max(std::fabs(commands.lowest), std::fabs(commands.highest));
  Form out;
  out.centre = largest * stream.uniform(0.3, 0.7) * (stream.chance(0.5) ? 1.0 : -1.0);
  // Commands of one sign never come by a notch on the other side.
  if (out.centre < commands.lowest || out.centre > commands.highest) out.centre = -out.centre;
  out.width = largest * stream.uniform(0.1, 0.25);
  return out;
}

/// Of the joint's neighbour: the next one out, of the last joint the one before.
int neighbour(int joint, const Robot& robot, const std::string& where) {
  if (robot.dof() < 2) throw InputError(where, "an arm of one joint", "two joints at least, for a cable over both");
  return joint + 1 < robot.dof() ? joint + 1 : joint - 1;
}

void refuse_unmoved(const Range& range, const std::string& what, const std::string& where) {
  if (!(range.width() > 0.0)) throw InputError(where, what + " is the same throughout", "recordings that change it");
}

/// Names of what a law goes over, as in `learned[].over` of a diagnosis.
std::vector<std::string> over(const OutsidePhysics& physics, const Experiment& experiment) {
  switch (info_of(physics.kind).over) {
    case OutsideWay::position: return {"q"};
    case OutsideWay::position_and_direction: return {"q", "v"};
    case OutsideWay::other_position: return {experiment.joint_names[physics.form.other] + ".q"};
    case OutsideWay::command: return {"u"};
    case OutsideWay::time: break;
  }
  return {"t"};
}

std::vector<LawRecord::Point> curve(const OutsidePhysics& physics, const Travel& travel) {
  std::vector<LawRecord::Point> out;
  const OutsideWay way = info_of(physics.kind).over;
  if (way == OutsideWay::time) return out;
  const int joint = way == OutsideWay::other_position ? physics.form.other : physics.joint;
  const Range& range = (way == OutsideWay::command ? travel.command : travel.position)[joint];
  if (way == OutsideWay::position_and_direction) {
    for (const double direction : {-1.0, 1.0})
      for (const double x : spread(range)) out.push_back({{x, direction}, outside_law(physics, x, direction)});
    return out;
  }
  for (const double x : spread(range)) out.push_back({{x}, outside_law(physics, x)});
  return out;
}

std::optional<double> value_of(const OutsidePhysics& physics) {
  if (physics.kind == Kind::external_push) return physics.strength;
  if (physics.kind == Kind::command_dropout) return 0.0;
  return std::nullopt;
}

std::vector<LawRecord::Event> events(const OutsidePhysics& physics, const Experiment& experiment,
                                     const std::vector<std::string>& files) {
  std::vector<LawRecord::Event> out;
  if (info_of(physics.kind).over != OutsideWay::time) return out;
  for (const Segment& segment : experiment.segments) {
    const std::size_t r = segment.recording;
    const double end = segment.time(segment.count - 1), clock = segment.commands->begin;
    for (const double from : physics.times[r])
      out.push_back({files[r], clock + from, clock + std::min(end, from + seconds_of(physics)), value_of(physics)});
  }
  return out;
}

}  // namespace

OutsidePhysics::Form drawn_form(const OutsidePhysics& physics, const Travel& travel, const Robot& robot,
                                RandomStream stream, const std::string& where) {
  const std::size_t j = physics.joint;
  Form out;
  switch (physics.kind) {
    case Kind::position_ripple:
      refuse_unmoved(travel.position[j], "the joint's position", where);
      out.width = travel.position[j].width() * std::exp(stream.uniform(std::log(1.0 / 12.0), std::log(1.0 / 3.0)));
      out.centre = -stream.uniform() * out.width;
      break;
    case Kind::counterbalance_spring:
      if (robot.joints()[j].prismatic()) throw InputError(where, "a joint that slides", "one that turns");
      refuse_unmoved(travel.position[j], "the joint's position", where);
      return drawn_spring(travel.position[j], stream);
    case Kind::tight_spot:
      refuse_unmoved(travel.position[j], "the joint's position", where);
      out.centre = uniform_in(travel.position[j], 1.0 / 6.0, 5.0 / 6.0, stream);
      out.width = travel.position[j].width() * stream.uniform(0.08, 0.2);
      out.slow = kSlowShare * travel.speed_rms[j];
      break;
    case Kind::valve_notch:
      refuse_unmoved(travel.command[j], "the joint's command", where);
      return drawn_notch(travel.command[j], stream);
    case Kind::cable_drag: {
      out.other = neighbour(physics.joint, robot, where);
      const Range& range = travel.position[out.other];
      refuse_unmoved(range, "the neighbour's position", where);
      out.centre = uniform_in(range, 1.0 / 3.0, 2.0 / 3.0, stream);
      out.width = range.width() * stream.uniform(0.15, 0.4);
      break;
    }
    case Kind::external_push:
    case Kind::command_dropout:
    case Kind::repeated_samples: break;
  }
  return out;
}

void repeat_samples(const std::vector<OutsidePhysics>& all, const Channel& channel, const Segment& segment,
                    std::vector<double>& signal) {
  for (const OutsidePhysics& physics : all) {
    if (physics.kind != Kind::repeated_samples || channel.kind != ChannelKind::position ||
        channel.joint != physics.joint)
      continue;
    for (const double from : physics.times[segment.recording]) {
      for (std::size_t k = 1; k < signal.size(); ++k)
        if (segment.time(k) >= from && segment.time(k) < from + physics.strength - kSameInstant)
          signal[k] = signal[k - 1];
    }
  }
}

LawRecord law_record(const OutsidePhysics& physics, const Travel& travel, const Experiment& experiment,
                     const std::vector<std::string>& files) {
  return {to_string(info_of(physics.kind).stage), over(physics, experiment), curve(physics, travel),
          events(physics, experiment, files)};
}

}  // namespace lacuna
