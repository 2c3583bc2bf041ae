#include "draft/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "physics/measured_motion.h"
#include "physics/noise.h"
#include "scenarios/error.h"
#include "scenarios/text.h"
#include "draft/facts.h"

namespace lacuna {
namespace {

/// Of two clocks' periods.
constexpr double kSamePeriod = 0.005;
const Eigen::Vector3d kGravity{0.0, 0.0, -9.81};

class Drafter {
 public:
  explicit Drafter(const DraftRequest& request) : request_(request), robot_(*request.robot) {}

  DraftFacts run() {
    match();
    read_clocks();
    read_units();
    collect_signals();
    look_at_positions();
    guess_actuators();
    guess_prediction();
    deal_out_roles();
    return std::move(facts_);
  }

 private:
  const std::vector<double>& column(const Recording& data, const std::string& name) const {
    return data.columns[data.find(name)];
  }

  /// Only what every recording has can be a channel.
  void match() {
    std::vector<std::string> common, others;
    for (const std::string& name : request_.recordings.front().data->names) {
      const bool everywhere = std::all_of(request_.recordings.begin(), request_.recordings.end(),
                                          [&](const DraftRecording& r) { return r.data->find(name) >= 0; });
      (everywhere ? common : others).push_back(name);
    }
    facts_.columns = match_columns(robot_, common);
    for (const std::string& name : others) facts_.columns.unused.push_back({name, "not every recording has it", true});
    if (common.empty())
      throw InputError(printable(request_.recordings.back().file), "no column that the other recordings have",
                       "the same columns in every recording");
    if (!facts_.columns.time.empty()) return;
    // As the scenario's own default: the first column is the clock.
    facts_.columns.time = common.front();
    std::erase_if(facts_.columns.columns, [&](const ColumnGuess& c) { return c.column == common.front(); });
    std::erase_if(facts_.columns.unused, [&](const UnusedColumn& c) { return c.column == common.front(); });
  }

  void read_clocks() {
    facts_.one_period = true;
    bool first = true;
    for (const DraftRecording& recording : request_.recordings) {
      const std::vector<double>& time = column(*recording.data, facts_.columns.time);
      check_clock(recording, time);
      const ClockGuess clock = guess_clock(time, facts_.columns.time_unit);
      if (first) facts_.clock = clock;
      if (clock.scale != facts_.clock.scale)
        throw InputError(printable(recording.file) + ": " + printable(facts_.columns.time, 60),
                         "a clock that looks like " + clock.unit + ", the first recording's like " + facts_.clock.unit,
                         "one unit in all, named in the column's name (time_ms)");
      facts_.one_period = facts_.one_period && clock.even &&
                          std::fabs(clock.period - facts_.clock.period) <= kSamePeriod * facts_.clock.period;
      facts_.clock.shortest = std::min(facts_.clock.shortest, clock.shortest);
      facts_.clock.longest = std::max(facts_.clock.longest, clock.longest);
      first = false;
    }
  }

  void check_clock(const DraftRecording& recording, const std::vector<double>& time) const {
    const std::string where = printable(recording.file) + ": " + printable(facts_.columns.time, 60);
    if (time.size() < 2) throw InputError(where, fmt::format("{} sample", time.size()), "at least 2");
    for (std::size_t i = 1; i < time.size(); ++i) {
      if (!(time[i] > time[i - 1]))
        throw InputError(
            where, fmt::format("{} after {} in row {}", format_number(time[i]), format_number(time[i - 1]), i + 1),
            "a time that increases (name the time column t or time)");
    }
  }

  std::vector<const Recording*> all_data() const {
    std::vector<const Recording*> out;
    for (const DraftRecording& recording : request_.recordings) out.push_back(recording.data.get());
    return out;
  }

  const Joint& joint_of(const ColumnGuess& guess) const { return robot_.joints()[guess.joint]; }

  void read_units() {
    const std::vector<const Recording*> data = all_data();
    for (const ColumnGuess& guess : facts_.columns.columns) {
      UnitGuess& unit = facts_.units[{guess.kind, guess.joint}];
      switch (guess.kind) {
        case ChannelKind::position:
        case ChannelKind::motor_position: unit = guess_position_unit(robot_, facts_.columns, guess, data); break;
        case ChannelKind::pressure_a:
        case ChannelKind::pressure_b: unit = guess_pressure_unit(facts_.columns, data, guess); break;
        case ChannelKind::effort: unit = guess_effort_unit(joint_of(guess), guess); break;
        case ChannelKind::velocity:
        case ChannelKind::command: break;  // below; as it comes
      }
    }
    for (const ColumnGuess& guess : facts_.columns.columns)
      if (guess.kind == ChannelKind::velocity) read_velocity_unit(guess);
  }

  void read_velocity_unit(const ColumnGuess& guess) {
    UnitGuess& unit = facts_.units[{ChannelKind::velocity, guess.joint}];
    const ColumnGuess* position = facts_.columns.find(ChannelKind::position, guess.joint);
    if (position == nullptr) {
      unit = {1.0, "taken as SI: there is no position to hold it against", false};
      return;
    }
    const Recording& data = *request_.recordings.front().data;
    std::vector<double> q = column(data, position->column), time = column(data, facts_.columns.time);
    for (double& x : q) x *= facts_.units[{ChannelKind::position, guess.joint}].scale;
    for (double& x : time) x *= facts_.clock.scale;
    unit = guess_velocity_unit(joint_of(guess), guess, time, q, column(data, guess.column));
  }

  /// Every recording in SI.
  void collect_signals() {
    const std::size_t dof = robot_.dof();
    for (const DraftRecording& recording : request_.recordings) {
      JointSignals signals;
      signals.time = column(*recording.data, facts_.columns.time);
      for (double& t : signals.time) t *= facts_.clock.scale;
      for (auto* of : {&signals.position, &signals.velocity, &signals.command, &signals.effort}) of->resize(dof);
      for (const ColumnGuess& guess : facts_.columns.columns) {
        std::vector<std::vector<double>>* into = guess.kind == ChannelKind::position   ? &signals.position
                                                 : guess.kind == ChannelKind::velocity ? &signals.velocity
                                                 : guess.kind == ChannelKind::command  ? &signals.command
                                                 : guess.kind == ChannelKind::effort   ? &signals.effort
                                                                                       : nullptr;
        if (into == nullptr) continue;
        std::vector<double>& values = (*into)[guess.joint];
        values = column(*recording.data, guess.column);
        for (double& x : values) x *= facts_.units[{guess.kind, guess.joint}].scale;
      }
      signals_.push_back(std::move(signals));
    }
  }

  void look_at_positions() {
    for (int j = 0; j < robot_.dof(); ++j) {
      const auto& first = signals_.front().position[j];
      if (first.empty()) continue;
      SignalFacts facts{HUGE_VAL, -HUGE_VAL, 0.0, noise_of(signals_.front().time, first), quantisation_step(first)};
      for (const JointSignals& signals : signals_) {
        for (const double x : signals.position[j])
          if (std::isfinite(x)) facts.low = std::min(facts.low, x), facts.high = std::max(facts.high, x);
      }
      const auto seen = std::find_if(first.begin(), first.end(), [](double x) { return std::isfinite(x); });
      facts.rest = seen == first.end() ? std::nan("") : *seen;
      facts_.positions[j] = facts;
    }
  }

  void guess_actuators() {
    std::vector<DriveHint> hints;
    for (int j = 0; j < robot_.dof(); ++j) {
      const ColumnGuess* command = facts_.columns.find(ChannelKind::command, j);
      const ColumnGuess* effort = facts_.columns.find(ChannelKind::effort, j);
      hints.push_back({command != nullptr, command != nullptr && command->is_effort, effort != nullptr,
                       effort != nullptr && effort->current});
    }
    facts_.actuation = guess_actuation(request_.robot, kGravity, signals_, hints);
    for (const ActuatorGuess& guess : facts_.actuation.joints) {
      const ColumnGuess* effort = facts_.columns.find(ChannelKind::effort, guess.joint);
      if (effort != nullptr && effort->current)
        facts_.units[{ChannelKind::effort, guess.joint}].scale *= guess.effort_scale;
    }
  }

  void guess_prediction() {
    const MotionBand& band = facts_.actuation.band;
    bool efforts = robot_.dof() > 0, springs = true, any = false;
    for (int j = 0; j < robot_.dof(); ++j) {
      const ActuatorGuess& guess = facts_.actuation.joints[j];
      efforts = efforts && facts_.measured(ChannelKind::effort, j) && facts_.measured(ChannelKind::position, j);
      springs = springs && (guess.holds || guess.model.empty());
      any = any || !guess.model.empty();
    }
    const auto digits = [](double x) { return parse_number(fmt::format("{:.2g}", x)).value_or(1.0); };
    if (efforts && band.cutoff_hz > 0.0 && std::isfinite(band.cutoff_hz)) {
      facts_.prediction = InverseDynamics{digits(band.cutoff_hz)};
      facts_.prediction_reason = fmt::format(
          "the effort of every joint is measured; Hz: twenty times the motion's own {:.2g} Hz, at most a fifth of the "
          "{:.4g} Hz of sampling",
          band.frequency, band.rate);
    } else if (springs && any) {
      facts_.prediction = FreeRun{};
      facts_.prediction_reason = "every driven joint is held by a spring: a simulation from the start does not drift";
    } else {
      const double periods = std::isfinite(band.middle) && band.middle > 0.0 ? 3.0 / band.middle : 1.0;
      facts_.prediction = Windows{digits(std::clamp(periods, 0.25, 2.0))};
      facts_.prediction_reason =
          "s: nothing holds every joint, so a long simulation drifts; windows start from what was measured";
    }
  }

  void deal_out_roles() {
    std::vector<RecordingSpan> spans;
    for (std::size_t i = 0; i < signals_.size(); ++i) {
      RecordingSpan span{request_.recordings[i].file, signals_[i].time,
                         std::vector<double>(signals_[i].time.size(), 0.0)};
      for (const std::vector<double>& q : signals_[i].position) add_speed(span, q);
      spans.push_back(std::move(span));
    }
    facts_.roles = guess_roles(spans);
  }

  static void add_speed(RecordingSpan& span, const std::vector<double>& q) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const double x : q)
      if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
    if (!(high > low)) return;
    constexpr std::size_t kReach = 5;  // samples either side: one sample's noise is no motion
    for (std::size_t i = kReach; i + kReach < q.size(); ++i) {
      const double change = std::fabs(q[i + kReach] - q[i - kReach]) / (high - low);
      if (std::isfinite(change)) span.speed[i] += change;
    }
    for (std::size_t i = 0; i < std::min(kReach, q.size()); ++i)
      span.speed[i] = span.speed[q.size() - 1 - i] = HUGE_VAL;
  }

  const DraftRequest& request_;
  const Robot& robot_;
  DraftFacts facts_;
  std::vector<JointSignals> signals_;
};

}  // namespace

Draft draft_scenario(const DraftRequest& request) {
  if (request.robot->dof() == 0)
    throw InputError(printable(request.robot_file), "a robot without moving joints", "at least one joint to identify");
  const DraftFacts facts = Drafter(request).run();
  Draft out;
  out.time_column = facts.columns.time, out.time_scale = facts.clock.scale;
  write_page(request, facts, out);
  return out;
}

std::string in_seconds(const std::string& file) {
  const std::size_t dot = file.find_last_of("./");
  const bool has_extension = dot != std::string::npos && file[dot] == '.' && dot > 0;
  return (has_extension ? file.substr(0, dot) : file) + "_in_s.csv";
}

}  // namespace lacuna
