// The draft as text: every key with the reason for its value beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenarios/text.h"
#include "draft/facts.h"

namespace lacuna {
namespace {

constexpr int kStartDigits = 3;

/// Start values need no more digits than they deserve.
std::string short_number(double value, int digits = kStartDigits) {
  return format_number(parse_number(fmt::format("{:.{}g}", value, digits)).value_or(0.0));
}

class PageWriter {
 public:
  PageWriter(const DraftRequest& request, const DraftFacts& facts, Draft& out)
      : request_(request), facts_(facts), out_(out) {}

  void write() {
    head();
    actuators();
    identify();
    channels();
    ask_doubts();
    noise();
    prediction();
    recordings();
    unused();
  }

 private:
  const Joint& joint(int j) const { return request_.robot->joints()[static_cast<std::size_t>(j)]; }
  std::string shown(int j) const { return printable(joint(j).name, 60); }
  int dof() const { return request_.robot->dof(); }
  const ActuatorGuess& actuator(int j) const { return facts_.actuation.joints[static_cast<std::size_t>(j)]; }
  std::string unit(int j) const { return joint(j).prismatic() ? "m" : "rad"; }

  void line(const std::string& text, const std::string& comment = "") {
    out_.yaml += comment.empty() ? text + "\n" : fmt::format("{:<46} # {}\n", text, printable(comment, 400));
  }
  void remark(const std::string& text) { out_.yaml += "# " + printable(text, 400) + "\n"; }
  void guess(const std::string& text) { out_.guesses.push_back(printable(text, 400)); }
  /// Asked in the text and on the screen.
  void ask(const std::string& text, const std::string& indent = "") {
    out_.yaml += indent + "# ASKED: " + printable(text, 400) + "\n";
    out_.questions.push_back(printable(text, 400));
  }

  void head() {
    remark(
        "Drafted by `lacuna init`. Every comment says how its value was found: check them, above all those that begin");
    remark("with GUESS; what only you know is marked ASKED. Values are SI: m, rad, s, kg, N, N m.");
    line("format: lacuna-scenario/1");
    line("name: " + yaml_scalar(request_.name));
    line("robot: " + yaml_scalar(request_.robot_file));
    line("gravity: [0, 0, -9.81]", "m/s^2; GUESS: the z axis of the robot's file points up");
    guess("gravity: the z axis of the robot's file points up");
    const ClockGuess& clock = facts_.clock;
    if (facts_.one_period) {
      line("sample_period: " + short_number(clock.period, 4), "s; every clock keeps to it within 1 %");
    } else {
      remark(fmt::format("sample_period is left out: the clock is uneven, steps of {:.3g} to {:.3g} s, median {:.4g} s",
                         clock.shortest, clock.longest, clock.period));
    }
    const std::string mass = short_number(request_.robot->moving_mass(), 4);
    if (!identifies_mass() || !any_free_gain()) return;
    line("# total_mass: " + mass,
         "kg; ASKED: the sum of the robot's file; put in what the moving links weigh, if you know");
    out_.questions.push_back("total_mass: what do the moving links weigh together? The robot's file says " + mass +
                             " kg. Without it efforts are known up to a common factor only");
  }

  static std::string parameters(const ActuatorGuess& a) {
    std::string out = fmt::format("model: {}, gain: {}", a.model, short_number(a.gain));
    if (a.model != "direct_effort")
      out += ", damping: " + short_number(a.damping) + ", stiffness: " + short_number(a.stiffness);
    if (a.model == "direct_effort") out += ", damping: " + short_number(a.damping);
    if (a.model == "torque_source") out += ", rest: " + short_number(a.rest);
    return out;
  }

  void actuators() {
    const bool any = std::any_of(facts_.actuation.joints.begin(), facts_.actuation.joints.end(),
                                 [](const ActuatorGuess& a) { return !a.model.empty(); });
    out_.yaml += "\n";
    if (any) line("actuators:", "start values of the search; `lacuna effects` has the models' equations");
    for (int j = 0; j < dof(); ++j) {
      const ActuatorGuess& a = actuator(j);
      if (a.model.empty()) {
        ask(fmt::format("actuators.{}: no command and no effort is recorded of it; it is taken to move freely",
                        shown(j)),
            "  ");
        continue;
      }
      const std::string text = fmt::format("  {}: {{{}}}", yaml_scalar(joint(j).name), parameters(a));
      line(text, (a.sure ? "" : "GUESS: ") + a.reason);
      guess(fmt::format("{}: {}: {}", shown(j), a.model, a.reason));
      if (!a.sure) out_.questions.push_back(fmt::format("actuators.{}: {}", shown(j), printable(a.reason)));
    }
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
    out_.yaml += "\n";
    line("identify:", "what is not known well, as factors of the start values");
    if (any_free_gain()) line(flow ? "  gain: {relative_bounds: [0.1, 10]}" : "  gain: {relative_bounds: [0.25, 4]}");
    if (flow) {
      remark("Masses and damping are left out: a stiff flow source hides them.");
      return;
    }
    line(direct ? "  damping: {relative_bounds: [0.05, 20]}" : "  damping: {relative_bounds: [0.25, 4]}");
    if (torque) line("  stiffness: {relative_bounds: [0.25, 4]}");
    for (const auto& [j, seen] : facts_.positions) {
      const double reach = 0.25 * (seen.high - seen.low), rest = actuator(j).rest;
      if (actuator(j).model == "torque_source" && reach > 0.0)
        line(fmt::format("  {}: {{bounds: [{}, {}]}}", yaml_scalar(joint(j).name + ".rest"), short_number(rest - reach),
                         short_number(rest + reach)));
    }
    line("  mass: {relative_bounds: [0.4, 2.5]}", "of every moving link; its shape is kept");
  }

  std::string column_text(const ColumnGuess& column, double scale, double offset,
                          const std::string& command_unit) const {
    if (scale == 1.0 && offset == 0.0 && command_unit.empty()) return yaml_scalar(column.column);
    std::string out = "{column: " + yaml_scalar(column.column);
    if (scale != 1.0) out += ", scale: " + short_number(scale, column.current ? kStartDigits : 12);
    if (offset != 0.0) out += ", offset: " + short_number(offset, 5);
    if (!command_unit.empty()) out += ", unit: " + yaml_scalar(command_unit);
    return out + "}";
  }

  void time_channel() {
    const ClockGuess& clock = facts_.clock;
    const std::string said = fmt::format("{}{}: {}", clock.sure ? "" : "GUESS: ", clock.unit, clock.reason);
    line("  time: " + yaml_scalar(facts_.columns.time),
         clock.scale == 1.0 ? said : said + "; written again in s, beside the recordings");
    guess(fmt::format("time: {} in {}: {}", printable(facts_.columns.time, 60), clock.unit, clock.reason));
    if (!clock.sure) out_.questions.push_back("channels.time: is it in " + clock.unit + "? " + clock.reason);
  }

  void channels() {
    out_.yaml += "\nchannels:\n";
    time_channel();
    for (const ChannelKind kind :
         {ChannelKind::command, ChannelKind::position, ChannelKind::velocity, ChannelKind::effort,
          ChannelKind::motor_position, ChannelKind::pressure_a, ChannelKind::pressure_b})
      channels_of(kind);
    if (std::none_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                     [](const ColumnGuess& c) { return c.kind == ChannelKind::position; }))
      ask("channels.position: no column is named like a joint's position (q, pos, angle, len with the joint's name or "
          "number)",
          "  ");
  }

  void channels_of(ChannelKind kind) {
    const bool any = std::any_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                                 [&](const ColumnGuess& c) { return c.kind == kind; });
    if (!any) return;
    line(fmt::format("  {}:", to_string(kind)), kind == ChannelKind::command ? "held between samples" : "");
    for (int j = 0; j < dof(); ++j) {
      if (const ColumnGuess* column = facts_.columns.find(kind, j)) {
        channel(*column);
      } else if (kind == ChannelKind::position) {
        ask(fmt::format("channels.position.{}: no column is named like its position{}", shown(j), candidates()),
            "    ");
      }
    }
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
    line(fmt::format("    {}: {}", yaml_scalar(joint(column.joint).name),
                     column_text(column, unit.scale, offset, command ? command_unit_of(column) : "")),
         (guessed ? "GUESS: " : "") + why);
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
    out_.yaml += "\n";
    remark("noise is left out: it is estimated from the recordings. Seen in the first (rms; where it starts):");
    for (const auto& [j, facts] : facts_.positions) {
      std::string text = fmt::format("  {}: rms {:.2g} {}, from {:.4g} to {:.4g}, starts at {:.4g}", shown(j),
                                     facts.noise, unit(j), facts.low, facts.high, facts.rest);
      if (facts.step > 0.0) text += fmt::format(", quantised to {:.3g}", facts.step);
      remark(text);
    }
  }

  void prediction() {
    out_.yaml += "\n";
    line("prediction: " + facts_.prediction, facts_.prediction_reason);
    guess("prediction: " + facts_.prediction + ": " + facts_.prediction_reason);
  }

  /// Recordings need a measured position; without one they wait as comments.
  void recordings() {
    const bool usable = std::any_of(facts_.columns.columns.begin(), facts_.columns.columns.end(),
                                    [](const ColumnGuess& c) { return c.kind == ChannelKind::position; });
    const std::string hidden = usable ? "" : "# ";
    out_.yaml += "\n";
    line(hidden + "recordings:",
         "train is fitted, validate decides what is real, test is only reported; GUESS: " + facts_.roles.reason);
    guess("recordings: " + facts_.roles.reason);
    for (const RoleGuess& role : facts_.roles.roles) {
      std::string text =
          fmt::format("{}  - {{file: {}, role: {}", hidden, yaml_scalar(file_of(role)), to_string(role.role));
      if (role.from) text += ", from: " + format_number(*role.from);
      if (role.to) text += ", to: " + format_number(*role.to);
      line(text + with_of(role) + "}");
    }
    const bool joined = std::any_of(request_.recordings.begin(), request_.recordings.end(),
                                    [](const DraftRecording& r) { return !r.with.empty(); });
    if (joined)
      out_.questions.push_back(
          "recordings: do the clocks of the files joined by with: agree? clock_offset adds s to the times of one");
  }

  std::string file_of(const RoleGuess& role) const {
    const std::string& file = request_.recordings[role.recording].file;
    return facts_.clock.scale == 1.0 ? file : in_seconds(file);
  }

  /// The files joined to a recording; what was written again in s is one file.
  std::string with_of(const RoleGuess& role) const {
    std::string out;
    if (facts_.clock.scale != 1.0) return out;
    for (const RecordingPart& part : request_.recordings[role.recording].with)
      out += (out.empty() ? ", with: [" : ", ") + yaml_scalar(part.file);
    return out.empty() ? out : out + "]";
  }

  void unused() {
    if (facts_.columns.unused.empty()) return;
    out_.yaml += "\n";
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
  std::map<std::string, std::vector<std::string>> doubts_;  ///< about which columns
};

}  // namespace

void write_page(const DraftRequest& request, const DraftFacts& facts, Draft& out) {
  PageWriter(request, facts, out).write();
}

}  // namespace lacuna
