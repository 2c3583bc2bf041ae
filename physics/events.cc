#include "physics/events.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenarios/error.h"

namespace lacuna {
namespace {

using Series = std::vector<std::vector<double>>;

/// A copy that may be changed, zeros where there is none yet.
std::shared_ptr<Series> copy_of(const std::shared_ptr<const Series>& series, std::size_t joints, std::size_t count) {
  return series ? std::make_shared<Series>(*series) : std::make_shared<Series>(joints, std::vector<double>(count, 0.0));
}

/// Integral of a unit event's course, up to an instant, s: up over `rise`, level, down over `rise`.
double course_until(const Event& event, double time) {
  const auto ramp = [&](double since) {
    if (since <= 0.0) return 0.0;
    if (event.rise <= 0.0) return since;
    return since < event.rise ? 0.5 * since * since / event.rise : since - 0.5 * event.rise;
  };
  return ramp(time - event.begin) - ramp(time - (event.end - event.rise));
}

void push(Segment& segment, const Event& event) {
  const auto pushes = copy_of(segment.pushes, segment.q0.size(), segment.count - 1);
  std::vector<double>& efforts = (*pushes)[event.joint];
  const std::vector<double> shares = mean_of_intervals(segment, event);
  for (std::size_t k = 0; k < efforts.size(); ++k) efforts[k] += event.value * shares[k];
  segment.pushes = pushes;
}

void command(Segment& segment, const Event& event) {
  const auto track = std::make_shared<CommandTrack>(*segment.commands);
  std::vector<double>& u = track->value[event.joint];
  for (std::size_t k = 0; k < u.size(); ++k)
    if (track->time[k] >= event.begin && track->time[k] < event.end) u[k] = event.value;
  segment.commands = track;
}

void slip(Segment& segment, const Event& event) {
  const std::size_t joint = event.joint;
  const auto slips = copy_of(segment.slips, segment.q0.size(), segment.count);
  const std::vector<double> shares = value_at_samples(segment, event);
  for (std::size_t k = 0; k < segment.count; ++k) (*slips)[joint][k] += event.value * shares[k];
  segment.q0[joint] -= event.value * shares.front();  // it was read with the slip
  segment.slips = slips;
}

bool has_command(const Scenario& scenario, const std::string& joint) {
  const auto commands = scenario.channels.of.find(ChannelKind::command);
  return commands != scenario.channels.of.end() && commands->second.count(joint) > 0;
}

}  // namespace

std::vector<double> mean_of_intervals(const Segment& segment, const Event& event) {
  std::vector<double> out;
  for (std::size_t k = 0; k + 1 < segment.count; ++k) {
    const double from = segment.time(k), to = segment.time(k + 1);
    out.push_back((course_until(event, to) - course_until(event, from)) / (to - from));
  }
  return out;
}

std::vector<double> value_at_samples(const Segment& segment, const Event& event) {
  std::vector<double> out;
  for (std::size_t k = 0; k < segment.count; ++k) {
    const double time = segment.time(k);
    const bool to_the_end = k + 1 == segment.count && time <= event.end;
    out.push_back(time >= event.begin && (time < event.end || to_the_end) ? 1.0 : 0.0);
  }
  return out;
}

void add_event(Segment& segment, const Event& event) {
  // A command from before the segment may still be on its way.
  const bool outside = event.end <= segment.time(0) || event.begin > segment.time(segment.count - 1);
  if (outside && event.kind != EventSpec::Kind::command) return;
  switch (event.kind) {
    case EventSpec::Kind::effort: return push(segment, event);
    case EventSpec::Kind::command: return command(segment, event);
    default: return slip(segment, event);
  }
}

void add_events(const Scenario& scenario, Experiment& experiment) {
  for (const EventSpec& spec : scenario.events) {
    if (std::holds_alternative<InverseDynamics>(scenario.prediction))
      throw InputError(spec.where, "an event with inverse_dynamics", "a simulated motion (free_run or horizon)");
    const auto& names = experiment.joint_names;
    const int joint = static_cast<int>(std::ranges::find(names, spec.joint) - names.begin());
    const bool read = std::ranges::any_of(
        experiment.channels, [&](const Channel& c) { return c.kind == ChannelKind::position && c.joint == joint; });
    if (spec.kind == EventSpec::Kind::command && !has_command(scenario, spec.joint))
      throw InputError(spec.where, "no command of " + quoted(spec.joint), "a joint with a command channel");
    if (spec.kind == EventSpec::Kind::reading && !read)
      throw InputError(spec.where, "no position of " + quoted(spec.joint), "a joint with a position channel");
    const auto in_file = [&](const Segment& segment) { return segment.file == spec.file; };
    if (std::ranges::none_of(experiment.segments, in_file)) continue;  // a part of the recordings only
    bool touched = false;
    for (Segment& segment : experiment.segments) {
      if (!in_file(segment)) continue;
      const double clock = segment.commands->begin;
      touched = touched || (spec.to > clock && spec.from < clock + segment.commands->time.back());
      add_event(segment, {spec.kind, joint, spec.from - clock, spec.to - clock, spec.value, spec.rise});
    }
    if (!touched)
      throw InputError(spec.where, fmt::format("from {} to {} s of {}", spec.from, spec.to, quoted(spec.file)),
                       "a time within what is used of that recording");
  }
}

EventSpec spec_of(const Event& event, const Segment& segment, const Experiment& experiment) {
  const double clock = segment.commands->begin;
  return {event.kind,        experiment.joint_names[event.joint],
          segment.file,      clock + event.begin,
          clock + event.end, event.value,
          event.rise,        "learned"};
}

}  // namespace lacuna
