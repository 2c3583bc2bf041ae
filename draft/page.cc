// The draft as text: every key with the reason for its value beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenarios/scenario_entries.h"
#include "scenarios/text.h"
#include "scenarios/yaml_writer.h"
#include "draft/facts.h"

namespace lacuna {
namespace {

constexpr int kStartDigits = 3;
constexpr std::size_t kCommentColumn = 46;

/// Start values need no more digits than they deserve.
double rounded(double value, int digits = kStartDigits) {
  return parse_number(fmt::format("{:.{}g}", value, digits)).value_or(0.0);
}

class PageWriter {
 public:
  PageWriter(const DraftRequest& request, const DraftFacts& facts, Draft& out)
      : request_(request), facts_(facts), out_(out) {}

  void write() {
    yaml_.map();
    head();
    actuators();
    identify();
    channels();
    ask_doubts();
    noise();
    prediction();
    recordings();
    unused();
    out_.yaml = yaml_.end().str() + "\n";
  }

 private:
  const Joint& joint(int j) const { return request_.robot->joints()[j]; }
  std::string shown(int j) const { return printable(joint(j).name, 60); }
  int dof() const { return request_.robot->dof(); }
  const ActuatorGuess& actuator(int j) const { return facts_.actuation.joints[j]; }
  std::string unit(int j) const { return joint(j).prismatic() ? "m" : "rad"; }

  /// Behind what was written last.
  void say(const std::string& reason) {
    if (!reason.empty()) yaml_.comment(printable(reason, 400));
  }
  void remark(const std::string& text) { yaml_.remark(printable(text, 400)); }
  void guess(const std::string& text) { out_.guesses.push_back(printable(text, 400)); }
  /// Asked in the text and on the screen.
  void ask(const std::string& text) {
    yaml_.remark("ASKED: " + printable(text, 400));
    out_.questions.push_back(printable(text, 400));
  }

  void head() {
    remark(
        "Drafted by `lacuna init`. Every comment says how its value was found: check them, above all those that begin");
    remark("with GUESS; what only you know is marked ASKED. Values are SI: m, rad, s, kg, N, N m.");
    yaml_.put("format", "lacuna-scenario/1").put("name", request_.name).put("robot", request_.robot_file);
    yaml_.put("gravity", {0.0, 0.0, -9.81}).comment("m/s^2; GUESS: the z axis of the robot's file points up");
    guess("gravity: the z axis of the robot's file points up");
    const ClockGuess& clock = facts_.clock;
    if (facts_.one_period) {
      yaml_.put("sample_period", rounded(clock.period, 4)).comment("s; every clock keeps to it within 1 %");
    } else {
      remark(fmt::format("sample_period is left out: the clock is uneven, steps of {:.3g} to {:.3g} s, median {:.4g} s",
                         clock.shortest, clock.longest, clock.period));
    }
    if (identifies_mass() && any_free_gain()) ask_total_mass();
  }

  void ask_total_mass() {
    const double mass = rounded(request_.robot->moving_mass(), 4);
    YamlWriter hidden(kCommentColumn);
    hidden.map().put("total_mass", mass);
    hidden.comment("kg; ASKED: the sum of the robot's file; put in what the moving links weigh, if you know");
    yaml_.remark(hidden.end().str());  // waits for the user to make up their mind
    out_.questions.push_back("total_mass: what do the moving links weigh together? The robot's file says " +
                             format_number(mass) + " kg. Without it efforts are known up to a common factor only");
  }

  void put_actuator(const ActuatorGuess& a) {
    yaml_.short_map().put("model", a.model).put("gain", rounded(a.gain)).put("damping", rounded(a.damping));
    if (a.model != "direct_effort") yaml_.put("stiffness", rounded(a.stiffness));
    if (a.model == "torque_source") yaml_.put("rest", rounded(a.rest));
    yaml_.end();
  }

  void actuators() {
    const bool any = std::any_of(facts_.actuation.joints.begin(), facts_.actuation.joints.end(),
                                 [](const ActuatorGuess& a) { return !a.model.empty(); });
    yaml_.blank_line();
    if (any) {
      yaml_.key("actuators").comment("start values of the search; `lacuna effects` has the models' equations").map();
    }
    for (int j = 0; j < dof(); ++j) {
      const ActuatorGuess& a = actuator(j);
      if (a.model.empty()) {
        ask(fmt::format("actuators.{}: no command and no effort is recorded of it; it is taken to move freely",
                        shown(j)));
        continue;
      }
      yaml_.key(joint(j).name);
      put_actuator(a);
      say((a.sure ? "" : "GUESS: ") + a.reason);
      guess(fmt::format("{}: {}: {}", shown(j), a.model, a.reason));
      if (!a.sure) out_.questions.push_back(fmt::format("actuators.{}: {}", shown(j), printable(a.reason)));
    }
    if (any) yaml_.end();
  }

  bool any_model(const std::string& model) const {
    return std::any_of(facts_.actuation.joints.begin(), facts_.actuation.joints.end(),
                       [&](const ActuatorGuess& a) { return a.model == model; });
  }
  /// Whether every gain is known: efforts are measured, or commanded as such.
  bool any_free_gain() const {
    for (int j = 0; j < dof(); ++j)
      if (!actuator(j).model.empty() && !facts_.measured(ChannelKind::effort, j) && !commands_effort(j)) return true;
    return false;
  }
  bool commands_effort(int j) const {
    const ColumnGuess* command = facts_.columns.find(ChannelKind::command, j);
    return command != nullptr && command->is_effort;
  }

  bool identifies_mass() const {
    return !any_model("flow_source") && (any_model("torque_source") || any_model("direct_effort"));
  }

  void identify() {
    const bool torque = any_model("torque_source"), direct = any_model("direct_effort");
    const bool flow = any_model("flow_source");
    if (!torque && !direct && !flow) return;
    yaml_.blank_line().key("identify").comment("what is not known well, as factors of the start values").map();
    if (any_free_gain()) put_factors("gain", flow ? 0.1 : 0.25, flow ? 10.0 : 4.0);
    if (flow) {
      remark("Masses and damping are left out: a stiff flow source hides them.");
    } else {
      put_factors("damping", direct ? 0.05 : 0.25, direct ? 20.0 : 4.0);
      if (torque) put_springs();
      put_factors("mass", 0.4, 2.5);
      yaml_.comment("of every moving link; its shape is kept");
    }
    yaml_.end();
  }

  void put_factors(const char* name, double least, double most) {
    yaml_.key(name).short_map().put("relative_bounds", {least, most}).end();
  }

  void put_springs() {
    put_factors("stiffness", 0.25, 4.0);
    for (const auto& [j, seen] : facts_.positions) {
      const double reach = 0.25 * (seen.high - seen.low), rest = actuator(j).rest;
      if (actuator(j).model != "torque_source" || !(reach > 0.0)) continue;
      yaml_.key(joint(j).name + ".rest").short_map();
      yaml_.put("bounds", {rounded(rest - reach), rounded(rest + reach)}).end();
    }
  }

  void time_channel() {
    const ClockGuess& clock = facts_.clock;
    const std::string said = fmt::format("{}{}: {}", clock.sure ? "" : "GUESS: ", clock.unit, clock.reason);
    yaml_.put("time", facts_.columns.time);
    say(clock.scale == 1.0 ? said : said + "; written again in s, beside the recordings");
    guess(fmt::format("time: {} in {}: {}", printable(facts_.columns.time, 60), clock.unit, clock.reason));
    if (!clock.sure) out_.questions.push_back("channels.time: is it in " + clock.unit + "? " + clock.reason);
  }

  void channels() {
    yaml_.blank_line().key("channels").map();
    time_channel();
    for (const ChannelKind kind :
         {ChannelKind::command, ChannelKind::position, ChannelKind::velocity, ChannelKind::effort,
          ChannelKind::motor_position, ChannelKind::pressure_a, ChannelKind::pressure_b})
      channels_of(kind);
    if (std::none_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                     [](const ColumnGuess& c) { return c.kind == ChannelKind::position; }))
      ask("channels.position: no column is named like a joint's position (q, pos, angle, len with the joint's name or "
          "number)");
    yaml_.end();
  }

  void channels_of(ChannelKind kind) {
    const bool any = std::any_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                                 [&](const ColumnGuess& c) { return c.kind == kind; });
    if (!any) return;
    yaml_.key(to_string(kind));
    if (kind == ChannelKind::command) yaml_.comment("held between samples");
    yaml_.map();
    for (int j = 0; j < dof(); ++j) {
      if (const ColumnGuess* column = facts_.columns.find(kind, j)) {
        channel(*column);
      } else if (kind == ChannelKind::position) {
        ask(fmt::format("channels.position.{}: no column is named like its position{}", shown(j), candidates()));
      }
    }
    yaml_.end();
  }

  std::string candidates() const {
    std::vector<std::string> names;
    for (const UnusedColumn& column : facts_.columns.unused)
      if (column.asks) names.push_back(column.column);
    return names.empty() ? "" : "; left over: " + one_of(names, 8);
  }

  void channel(const ColumnGuess& column) {
    const UnitGuess& unit = facts_.units.at({column.kind, column.joint});
    const bool command = column.kind == ChannelKind::command;
    const double offset = command && actuator(column.joint).neutral != 0.0 ? -actuator(column.joint).neutral : 0.0;
    std::string value = command ? "" : unit.text;
    bool sure = unit.sure;
    if (offset != 0.0) value = fmt::format("the joint stands still at {:.4g}", -offset), sure = false;
    if (column.current) {
      value = fmt::format("motor current times {:.3g} {} per A, as the file's masses need", unit.scale,
                          joint(column.joint).prismatic() ? "N" : "N m");
      sure = false;
    }
    const std::string why = column.reason + (value.empty() ? "" : "; " + value);
    const bool guessed = !column.sure || !sure;
    put_column(yaml_, joint(column.joint).name,
               {.column = column.column,
                .scale = unit.scale == 1.0 ? 1.0 : rounded(unit.scale, column.current ? kStartDigits : 12),
                .offset = offset == 0.0 ? 0.0 : rounded(offset, 5),
                .where = "",
                .unit = command ? command_unit_of(column) : ""});
    say((guessed ? "GUESS: " : "") + why);
    guess(fmt::format("{} of {}: {}: {}", to_string(column.kind), shown(column.joint), printable(column.column, 60),
                      why));
    const std::string pair = printable(column.column, 60) + " of " + shown(column.joint);
    if (!column.sure) doubts_[fmt::format("channels.{}: {}", to_string(column.kind), column.reason)].push_back(pair);
    if (!sure) doubts_[fmt::format("channels.{}: {}", to_string(column.kind), value)].push_back(pair);
  }

  /// Each doubt once, with all that it is about.
  void ask_doubts() {
    for (const auto& [doubt, about] : doubts_) {
      std::string list;
      for (const std::string& each : about) list += (list.empty() ? "" : ", ") + each;
      out_.questions.push_back(printable(doubt + " (" + list + ")", 400));
    }
  }

  std::string command_unit_of(const ColumnGuess& column) const {
    if (column.is_effort) return joint(column.joint).prismatic() ? "N" : "N m";
    if (column.unit == "v") return "V";
    if (column.unit == "a") return "A";
    if (column.unit == "ma") return "mA";
    if (column.unit == "percent" || column.unit == "pct") return "%";
    return "";
  }

  void noise() {
    if (facts_.positions.empty()) return;
    yaml_.blank_line();
    remark("noise is left out: it is estimated from the recordings. Seen in the first (rms; where it starts):");
    for (const auto& [j, facts] : facts_.positions) {
      std::string text = fmt::format("  {}: rms {:.2g} {}, from {:.4g} to {:.4g}, starts at {:.4g}", shown(j),
                                     facts.noise, unit(j), facts.low, facts.high, facts.rest);
      if (facts.step > 0.0) text += fmt::format(", quantised to {:.3g}", facts.step);
      remark(text);
    }
  }

  void prediction() {
    yaml_.blank_line();
    put_prediction(yaml_, facts_.prediction);
    say(facts_.prediction_reason);
    YamlWriter alone;
    put_prediction(alone.map(), facts_.prediction);
    guess(alone.end().str() + ": " + facts_.prediction_reason);
  }

  /// Recordings need a measured position; without one they wait as comments.
  void recordings() {
    const bool usable = std::any_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                                    [](const ColumnGuess& c) { return c.kind == ChannelKind::position; });
    yaml_.blank_line();
    if (usable) {
      put_recordings(yaml_);
    } else {
      YamlWriter hidden(kCommentColumn);
      put_recordings(hidden.map());
      yaml_.remark(hidden.end().str());
    }
    guess("recordings: " + facts_.roles.reason);
    const bool joined = std::any_of(request_.recordings.begin(), request_.recordings.end(),
                                    [](const DraftRecording& r) { return !r.with.empty(); });
    if (joined)
      out_.questions.push_back(
          "recordings: do the clocks of the files joined by with: agree? clock_offset adds s to the times of one");
  }

  void put_recordings(YamlWriter& yaml) const {
    yaml.key("recordings")
        .comment(printable(
            "train is fitted, validate decides what is real, test is only reported; GUESS: " + facts_.roles.reason,
            400));
    yaml.list();
    for (const RoleGuess& role : facts_.roles.roles) {
      yaml.short_map().put("file", file_of(role)).put("role", to_string(role.role));
      if (role.from) yaml.put("from", *role.from);
      if (role.to) yaml.put("to", *role.to);
      put_joined(yaml, request_.recordings[role.recording].with);
      yaml.end();
    }
    yaml.end();
  }

  std::string file_of(const RoleGuess& role) const {
    const std::string& file = request_.recordings[role.recording].file;
    return facts_.clock.scale == 1.0 ? file : in_seconds(file);
  }

  /// The files joined to a recording; what was written again in s is one file.
  void put_joined(YamlWriter& yaml, const std::vector<RecordingPart>& parts) const {
    if (facts_.clock.scale != 1.0 || parts.empty()) return;
    yaml.key("with").short_list();
    for (const RecordingPart& part : parts) yaml.value(part.file);
    yaml.end();
  }

  void unused() {
    if (facts_.columns.unused.empty()) return;
    yaml_.blank_line();
    remark("Columns without a place here:");
    for (const UnusedColumn& column : facts_.columns.unused) {
      remark(fmt::format("  {}: {}", printable(column.column, 60), column.reason));
      if (column.asks)
        out_.questions.push_back(fmt::format("column {}: {}", printable(column.column, 60), column.reason));
    }
  }

  const DraftRequest& request_;
  const DraftFacts& facts_;
  Draft& out_;
  YamlWriter yaml_{kCommentColumn};
  std::map<std::string, std::vector<std::string>> doubts_;  ///< about which columns
};

}  // namespace

void write_page(const DraftRequest& request, const DraftFacts& facts, Draft& out) {
  PageWriter(request, facts, out).write();
}

}  // namespace lacuna
