#include "diagnosis/events.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/baseline.h"
#include "diagnosis/event_search.h"

namespace lacuna {
namespace {

constexpr double kTouching = 0.1;  ///< s between rectangles of one event, at most
constexpr int kSharpened = 3;      ///< times that events are sized anew about the motion with them
constexpr double kStands = 1e-3;   ///< relative change of what is left, under which they stay as they are
constexpr int kShifts = 4;         ///< samples either way that the edges of a lost command are looked for
constexpr int kRefitSteps = 10;

using Events = std::vector<FoundEvent>;

Experiment with_events(const Experiment& experiment, const Events& events) {
  Experiment out = experiment;
  for (const FoundEvent& one : events) add_event(out.segments[static_cast<std::size_t>(one.segment)], one.event);
  return out;
}

/// Events at one joint of a segment that follow one another without a pause.
std::vector<Events> joined(Events events) {
  std::vector<Events> out;
  std::ranges::stable_sort(events, {}, [](const FoundEvent& f) { return std::pair(f.segment, f.event.begin); });
  for (const FoundEvent& one : events) {
    const auto same = std::ranges::find_if(out, [&](const Events& group) {
      const Event& last = group.back().event;
      return group.back().segment == one.segment && last.kind == one.event.kind && last.joint == one.event.joint &&
             last.kind != EventSpec::Kind::command && one.event.begin - last.end < kTouching;
    });
    (same == out.end() ? out.emplace_back() : *same).push_back(one);
  }
  return out;
}

bool is_same(const FoundEvent& a, const FoundEvent& b) {
  return a.segment == b.segment && a.event.kind == b.event.kind && a.event.joint == b.event.joint &&
         a.event.begin == b.event.begin && a.event.end == b.event.end;
}

Events all_but(Events events, const Events& group) {
  std::erase_if(events, [&](const FoundEvent& one) {
    return std::ranges::any_of(group, [&](const FoundEvent& g) { return is_same(g, one); });
  });
  return events;
}

class EventFinder {
 public:
  EventFinder(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
              const RunControl& control)
      : recorded_(experiment), simulator_(simulator), control_(control), model_(current) {
    control_.progress = nullptr;
  }

  EventsFound run() {
    Events all = found_in(Role::train), validate = found_in(Role::validate);
    all.insert(all.end(), validate.begin(), validate.end());
    Experiment with = with_events(recorded_, all);
    const Events test = found_in(Role::test);
    all.insert(all.end(), test.begin(), test.end());
    EventsFound out{model_, std::move(with), {}};
    for (const Events& group : joined(all)) out.events.push_back(described(group));
    return out;
  }

 private:
  /// Searched to first order, then put into the simulation; those of the train recordings with the model's numbers
  /// fitted beside them.
  Events found_in(Role role) {
    const std::vector<int> segments = recorded_.with_role(role);
    if (segments.empty()) return {};
    const bool fitted = role == Role::train;
    const Hypotheses sets(model_, recorded_, simulator_, control_);
    Events events = search_events(sets, model_, recorded_, segments, fitted);
    if (events.empty()) return events;
    settle(segments, fitted, events);
    name_commands(events);
    if (fitted) settle(segments, fitted, events);
    return events;
  }

  /// Energy that a model leaves of segments of an experiment, each on its own; in this finder's first weights.
  std::vector<double> left_by(const CurrentModel& model, const Experiment& experiment,
                              const std::vector<int>& segments) const {
    Problem problem(model.model, experiment, model.space, simulator_, model_.weights);
    const Eigen::VectorXd rest = problem.residual(model.fit.point, segments);
    std::vector<double> out(segments.size(), 0.0);
    for (const ResidualBlock& b : problem.layout(segments)) {
      const auto at = std::ranges::find(segments, b.segment) - segments.begin();
      out[static_cast<std::size_t>(at)] += rest.segment(b.first, b.count).squaredNorm();
    }
    return out;
  }
  double left_of(const CurrentModel& model, const Experiment& experiment, const std::vector<int>& segments) const {
    const std::vector<double> each = left_by(model, experiment, segments);
    return std::accumulate(each.begin(), each.end(), 0.0);
  }

  /// Sizes, edges and, where they are `fitted`, the model's numbers in full simulation, as long as less is left.
  void settle(const std::vector<int>& segments, bool fitted, Events& events) {
    Events tried = events;
    double least = HUGE_VAL;
    for (int k = 0; k < kSharpened; ++k) {
      const Experiment with = with_events(recorded_, tried);
      CurrentModel model = model_;
      const Hypotheses sets(model_, with, simulator_, control_);
      if (fitted && !sets.fit(model, kRefitSteps)) return;
      const double left = left_of(model, with, segments);
      if (!(left < least)) return;
      const bool stands = left > (1.0 - kStands) * least;
      least = left, events = tried;
      if (fitted) model_ = std::move(model);
      if (stands) return;
      sharpen(Hypotheses(model_, with, simulator_, control_), model_, with, segments, fitted, tried);
    }
  }

  /// Where an effort does no better than a command that was lost or stayed, it is that.
  void name_commands(Events& events) const {
    for (const Events& group : joined(events)) {
      if (group.front().event.kind != EventSpec::Kind::effort) continue;
      const int segment = group.front().segment;
      const Events others = all_but(events, group);
      const Segment without = with_events(recorded_, others).segments[static_cast<std::size_t>(segment)];
      const Events offered = commands_around(without, group);
      if (offered.empty()) continue;
      Experiment trial = recorded_;
      trial.segments.assign(offered.size(), without);
      std::vector<int> all;
      for (std::size_t k = 0; k < offered.size(); ++k)
        add_event(trial.segments[k], offered[k].event), all.push_back(static_cast<int>(k));
      const std::vector<double> left = left_by(model_, trial, all);
      const auto best = std::ranges::min_element(left);
      if (!(*best < left_of(model_, with_events(recorded_, events), {segment}))) continue;
      events = others;
      events.push_back(offered[static_cast<std::size_t>(best - left.begin())]);
    }
  }
  /// Commands lost and repeated from about an instant to about another.
  static Events commands_around(const Segment& segment, const Events& effort) {
    const FoundEvent& first = effort.front();
    const std::vector<double>& u = segment.commands->value[static_cast<std::size_t>(first.event.joint)];
    if (std::ranges::none_of(u, [](double x) { return x != 0.0; })) return {};
    const auto sample_at = [&](double time) {
      std::size_t k = 0;
      while (k + 1 < segment.count && segment.time(k) < time) ++k;
      return static_cast<int>(k);
    };
    double until = first.event.end, evidence = first.evidence;
    for (const FoundEvent& one : effort)
      until = std::max(until, one.event.end), evidence = std::max(evidence, one.evidence);
    const int from = sample_at(first.event.begin), to = sample_at(until), last = static_cast<int>(segment.count) - 1;
    Events out;
    for (int a = std::max(1, from - kShifts); a <= std::min(last, from + kShifts); ++a)
      for (int b = std::max(a + 1, to - kShifts); b <= std::min(last, to + kShifts); ++b) {
        const double before = u[segment.first + static_cast<std::size_t>(a) - 1];
        Event lost{EventSpec::Kind::command, first.event.joint, segment.time(static_cast<std::size_t>(a)),
                   segment.time(static_cast<std::size_t>(b)), 0.0};
        out.push_back({first.segment, lost, evidence});
        if (before == 0.0) continue;
        lost.value = before;
        out.push_back({first.segment, lost, evidence});
      }
    return out;
  }

  LearnedEvent described(const Events& group) const {
    const Segment& in = recorded_.segments[static_cast<std::size_t>(group.front().segment)];
    const Event& first = group.front().event;
    LearnedEvent out;
    out.kind = first.kind, out.recording = in.file, out.role = in.role;
    out.from = HUGE_VAL, out.to = -HUGE_VAL, out.evidence = -HUGE_VAL;
    for (const FoundEvent& one : group) {
      const EventSpec piece = spec_of(one.event, in, recorded_);
      out.place = piece.joint;
      out.from = std::min(out.from, piece.from), out.to = std::max(out.to, piece.to);
      if (std::fabs(piece.value) > std::fabs(out.value)) out.value = piece.value;
      out.evidence = std::max(out.evidence, one.evidence);
      out.pieces.push_back(piece);
    }
    const bool sliding = model_.model.robot().joints()[static_cast<std::size_t>(first.joint)].prismatic();
    switch (first.kind) {
      case EventSpec::Kind::effort: out.unit = sliding ? "N" : "N m", out.resembles = "a push"; break;
      case EventSpec::Kind::command:
        out.resembles = first.value == 0.0 ? "a lost command" : "a repeated command";
        break;
      default: out.unit = sliding ? "m" : "rad", out.resembles = "a slip of the transducer";
    }
    return out;
  }

  const Experiment& recorded_;
  SimulatorOptions simulator_;
  RunControl control_;
  CurrentModel model_;
};

}  // namespace

EventsFound find_events(const CurrentModel& current, const Experiment& experiment, const SimulatorOptions& simulator,
                        const RunControl& control) {
  if (std::holds_alternative<InverseDynamics>(experiment.prediction)) return {current, experiment, {}};
  return EventFinder(current, experiment, simulator, control).run();
}

}  // namespace lacuna
