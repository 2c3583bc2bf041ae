#include "diagnosis/events.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/event_search.h"
#include "diagnosis/hypothesis.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

constexpr double kTouching = 0.1;      ///< s between rectangles of one event, at most
constexpr int kSharpened = 3;          ///< times that events are sized anew about the motion with them
constexpr double kEventsStand = 1e-3;  ///< relative change of what is left, under which they stay as they are
constexpr double kExplained = 1.5;     ///< times the noise: what a recording leaves at most that events explain
constexpr double kSparse = 0.5;        ///< of the recordings, over which events of one kind and joint lie at most
constexpr int kRounds = 6;             ///< at most
constexpr double kWake = 0.05;         ///< of the recording, on either side of a stronger event
constexpr int kShifts = 8;             ///< samples, by which the edges of a lost command are moved at first
constexpr int kEventRefitSteps = 10;
constexpr double kNumbersOfCommand = 2.0;  ///< its edges

using Events = std::vector<FoundEvent>;

Segment with_events(const Experiment& experiment, int segment, const Events& events) {
  Segment out = experiment.segments[segment];
  for (const FoundEvent& one : events)
    if (one.segment == segment) add_event(out, one.event);
  return out;
}
Experiment with_events(const Experiment& experiment, const Events& events) {
  Experiment out = experiment;
  for (const FoundEvent& one : events) add_event(out.segments[one.segment], one.event);
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
  EventFinder(const CurrentModel& current, const FitContext& context)
      : recorded_(context.experiment), context_(context), model_(current), weights_(current.weights) {}

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
  /// In rounds: searched to first order, then put into the simulation, those of the train recordings with the model's
  /// numbers fitted beside them.
  Events found_in(Role role) {
    const std::vector<int> segments = recorded_.with_role(role);
    const bool fitted = role == Role::train;
    const CurrentModel begun = model_;
    Events events;
    for (int round = 0; round < kRounds && !segments.empty(); ++round) {
      const Experiment with = with_events(recorded_, events);
      const Events more = foremost(search_events(model_, context_.on(with), segments, fitted));
      if (more.empty()) break;
      Events all = events;
      all.insert(all.end(), more.begin(), more.end());
      const double before = left_of(model_, with, segments);
      const CurrentModel model = model_;
      if (!settle(segments, fitted, before, all)) break;
      name_commands(segments, fitted, all);
      drop_needless(segments, fitted, all);
      settle(segments, fitted, HUGE_VAL, all);
      if (!(left_of(model_, with_events(recorded_, all), segments) < (1.0 - kEventsStand) * before)) {
        model_ = model;
        break;
      }
      events = std::move(all);
    }
    return explained(events, segments, fitted, begun);
  }

  /// Events where, with them in, their recording is explained; where it is not, what seems to happen may be the model's
  /// own mistake. Recordings that are fitted together stand or fall together. What happens most of the time is none,
  /// either.
  Events explained(Events events, const std::vector<int>& segments, bool fitted, const CurrentModel& begun) {
    if (!is_sparse(events, segments)) {
      model_ = begun;
      return {};
    }
    const Experiment with = with_events(recorded_, events);
    std::set<int> open;
    for (const FoundEvent& one : events)
      if (!is_explained(with, one.segment)) open.insert(one.segment);
    if (fitted && !open.empty()) {
      model_ = begun;
      return {};
    }
    std::erase_if(events, [&](const FoundEvent& one) { return open.count(one.segment) > 0; });
    return events;
  }
  bool is_sparse(const Events& events, const std::vector<int>& segments) const {
    double span = 0.0;
    for (const int s : segments) {
      const Segment& segment = recorded_.segments[s];
      span += segment.time(segment.count - 1);
    }
    std::map<std::pair<EventSpec::Kind, int>, double> lasting;
    for (const FoundEvent& one : events) lasting[{one.event.kind, one.event.joint}] += one.event.end - one.event.begin;
    return std::ranges::all_of(lasting, [&](const auto& entry) { return entry.second <= kSparse * span; });
  }
  /// Whether every channel leaves about its noise; of an unknown one nobody can say.
  bool is_explained(const Experiment& with, int segment) const {
    const std::vector<double> noise = noise_levels(with);
    Problem problem = problem_of(model_, context_.on(with), noise_or_one(noise));
    const std::vector<int> one{segment};
    const Eigen::VectorXd rest = problem.residual(model_.fit.point, one);
    return std::ranges::all_of(problem.layout(one), [&](const ResidualBlock& b) {
      const double power = rest.segment(b.first, b.count).squaredNorm();
      return !(noise[b.channel] > 0.0) || power <= kExplained * kExplained * static_cast<double>(b.count);
    });
  }
  static std::vector<double> noise_or_one(std::vector<double> noise) {
    for (double& level : noise)
      if (!(level > 0.0)) level = 1.0;
    return noise;
  }

  /// Those that no stronger one comes close to: what seems to happen in its wake may be what a rectangle and first
  /// order leave of it.
  Events foremost(Events events) const {
    std::ranges::stable_sort(events, std::greater<>{}, &FoundEvent::evidence);
    Events out;
    for (const FoundEvent& one : events) {
      const Segment& segment = recorded_.segments[one.segment];
      const double wake = kWake * (segment.time(segment.count - 1) - segment.time(0));
      const bool follows = std::ranges::any_of(out, [&](const FoundEvent& other) {
        return other.segment == one.segment && one.event.begin < other.event.end + wake &&
               other.event.begin < one.event.end + wake;
      });
      if (!follows) out.push_back(one);
    }
    return out;
  }

  /// Energy that a model leaves of segments, in this finder's first weights.
  double left_of(const CurrentModel& model, const Experiment& experiment, const std::vector<int>& segments) const {
    Problem problem = problem_of(model, context_.on(experiment), weights_);
    return problem.residual(model.fit.point, segments).squaredNorm();
  }

  /// Log-likelihood that is lost with other events in one segment, each in place of `events`, the parameters that were
  /// fitted to these segments having taken up what they can.
  std::vector<double> losses(const std::vector<int>& segments, bool fitted, const Events& events, int segment,
                             const std::vector<Events>& others) const {
    const Experiment with = with_events(recorded_, events);
    Experiment trial = recorded_;
    trial.segments.clear();
    for (const Events& own : others) trial.segments.push_back(with_events(recorded_, segment, own));
    std::vector<int> all(trial.segments.size());
    std::iota(all.begin(), all.end(), 0);
    Problem problem = problem_of(model_, context_.on(with));
    Problem tried = problem_of(model_, context_.on(trial));
    const Eigen::VectorXd now = problem.residual(model_.fit.point, segments),
                          then = tried.residual(model_.fit.point, all);
    Eigen::Index first = now.size(), count = 0;
    for (const ResidualBlock& b : problem.layout(segments))
      if (b.segment == segment) first = std::min(first, b.first), count += b.count;
    const Eigen::MatrixXd& jacobian = model_.fit.jacobian;
    const bool gives_way = fitted && jacobian.rows() == now.size() && jacobian.allFinite();
    const Eigen::MatrixXd basis = gives_way ? Projector(jacobian).basis() : Eigen::MatrixXd(now.size(), 0);
    const auto energy = [&](const Eigen::VectorXd& r) {
      return r.squaredNorm() - (basis.transpose() * r).squaredNorm();
    };
    std::vector<double> out;
    for (std::size_t k = 0; k < others.size(); ++k) {
      Eigen::VectorXd r = now;
      r.segment(first, count) = then.segment(static_cast<Eigen::Index>(k) * count, count);
      out.push_back(0.5 * static_cast<double>(r.size()) * std::log(energy(r) / energy(now)));
    }
    return out;
  }

  /// Sizes, edges and, where they are `fitted`, the model's numbers in full simulation, as long as less is left. False:
  /// never less than `before`.
  bool settle(const std::vector<int>& segments, bool fitted, double before, Events& events) {
    Events tried = events;
    bool any = false;
    double least = (1.0 - kEventsStand) * before;
    for (int k = 0; k < kSharpened; ++k) {
      const Experiment with = with_events(recorded_, tried);
      CurrentModel model = model_;
      const Hypotheses sets(model_, context_.on(with));
      if (fitted && !sets.fit(model, kEventRefitSteps)) break;
      const double left = left_of(model, with, segments);
      if (!(left < least)) break;
      const bool stands = any && left > (1.0 - kEventsStand) * least;
      least = left, events = tried, any = true;
      if (fitted) model_ = std::move(model);
      if (stands) break;
      sharpen(model_, context_.on(with), segments, fitted, tried);
    }
    return any;
  }

  /// Where efforts and slips at about the same time do no better together than a command that was lost or stayed, they
  /// are that (Schwarz's criterion); commands' edges are moved to where they leave least.
  void name_commands(const std::vector<int>& segments, bool fitted, Events& events) const {
    for (const Events& group : joined(events)) {
      Events beside;
      for (const FoundEvent& one : events)
        if (is_beside(one, group)) beside.push_back(one);
      if (beside.empty()) continue;  // it went with another group
      double spared = -kNumbersOfCommand;
      for (const FoundEvent& one : beside) spared += numbers_of(one);
      const double allowed = 0.5 * spared * std::log(samples_of(segments));
      const Events others = all_but(events, beside);
      if (const std::optional<FoundEvent> command = best_command(segments, fitted, events, others, group, allowed)) {
        events = others;
        events.push_back(*command);
      }
    }
  }
  /// At about the same time in the same segment.
  static bool is_beside(const FoundEvent& one, const Events& group) {
    return std::ranges::any_of(group, [&](const FoundEvent& other) {
      return other.segment == one.segment && other.event.begin < one.event.end + kTouching &&
             one.event.begin < other.event.end + kTouching;
    });
  }
  /// That an event is given by: its edges, its size, its rise.
  static double numbers_of(const FoundEvent& one) {
    switch (one.event.kind) {
      case EventSpec::Kind::effort: return 4.0;
      case EventSpec::Kind::reading: return 3.0;
      default: return kNumbersOfCommand;
    }
  }
  double samples_of(const std::vector<int>& segments) const {
    double out = 0.0;
    for (const int s : segments) out += static_cast<double>(recorded_.channels.size() * recorded_.segments[s].count);
    return out;
  }
  /// The lost or repeated command beside `others` and in place of a group that loses no more than `allowed`; by steps
  /// of the edges that become shorter.
  std::optional<FoundEvent> best_command(const std::vector<int>& segments, bool fitted, const Events& events,
                                         const Events& others, const Events& group, double allowed) const {
    const int segment = group.front().segment;
    const Segment without = with_events(recorded_, segment, others);
    const std::size_t joint = group.front().event.joint;
    if (std::ranges::none_of(without.commands->value[joint], [](double x) { return x != 0.0; })) return std::nullopt;
    FoundEvent about = group.front();
    for (const FoundEvent& one : group) {
      about.event.end = std::max(about.event.end, one.event.end);
      about.evidence = std::max(about.evidence, one.evidence);
    }
    double least = HUGE_VAL;
    // Once more at the finest step first: edges that are right already must not be walked away from.
    for (const int step : {1, kShifts, kShifts / 2, kShifts / 4, 1}) {
      const Events offered = commands_around(without, about, step);
      std::vector<Events> tried;
      for (const FoundEvent& one : offered) tried.push_back(others), tried.back().push_back(one);
      const std::vector<double> lost = losses(segments, fitted, events, segment, tried);
      const auto here = std::ranges::min_element(lost);
      if (!(*here < least)) continue;
      least = *here, about = offered[here - lost.begin()];
    }
    if (!(least < allowed)) return std::nullopt;
    return about;
  }
  /// Commands lost and repeated whose edges are up to two steps of samples away from an event's.
  static Events commands_around(const Segment& segment, const FoundEvent& about, int step) {
    const std::vector<double>& u = segment.commands->value[about.event.joint];
    const int last = static_cast<int>(segment.count) - 1;
    const auto sample_at = [&](double time) {
      int k = 0;
      while (k < last && segment.time(static_cast<std::size_t>(k)) < time) ++k;
      return k;
    };
    const int from = sample_at(about.event.begin), to = sample_at(about.event.end);
    Events out;
    for (int a = -2; a <= 2; ++a)
      for (int b = -2; b <= 2; ++b) {
        const int first = std::clamp(from + a * step, 1, last - 1), end = std::clamp(to + b * step, first + 1, last);
        const double before = u[segment.first + static_cast<std::size_t>(first) - 1];
        FoundEvent lost = about;
        lost.event = {EventSpec::Kind::command, about.event.joint, segment.time(static_cast<std::size_t>(first)),
                      segment.time(static_cast<std::size_t>(end)), 0.0};
        out.push_back(lost);
        lost.event.value = before;
        if (before != 0.0) out.push_back(lost);
      }
    return out;
  }

  /// Takes out, the least first, what the simulation can do without.
  void drop_needless(const std::vector<int>& segments, bool fitted, Events& events) const {
    for (const int segment : segments) {
      for (;;) {
        std::vector<Events> without;
        for (const FoundEvent& one : events)
          if (one.segment == segment) without.push_back(all_but(events, {one}));
        if (without.empty()) break;
        const std::vector<double> lost = losses(segments, fitted, events, segment, without);
        const auto least = std::ranges::min_element(lost);
        if (*least > kWorthLearning) break;
        events = without[least - lost.begin()];
      }
    }
  }

  LearnedEvent described(const Events& group) const {
    const Segment& in = recorded_.segments[group.front().segment];
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
    const bool sliding = model_.model.robot().joints()[first.joint].prismatic();
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
  FitContext context_;
  CurrentModel model_;
  std::vector<double> weights_;  ///< the first ones: what is left is compared in them
};

}  // namespace

EventsFound find_events(const CurrentModel& current, const FitContext& context) {
  if (!std::holds_alternative<FreeRun>(context.experiment.prediction)) return {current, context.experiment, {}};
  return EventFinder(current, context).run();
}

}  // namespace lacuna
