#include "draft/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>

#include "scenarios/text.h"
#include "draft/names.h"

namespace lacuna {
namespace {

using Words = std::set<std::string>;

/// What a word says of the quantity.
enum class Sense {
  position,
  velocity,
  acceleration,
  command,
  effort,
  current,
  reference,
  pressure,
  side_a,
  side_b,
  motor
};

const std::map<Sense, Words>& dictionary() {
  static const std::map<Sense, Words> kWords{
      {Sense::position,
       {"q", "pos", "position", "positions", "angle", "ang", "theta", "phi", "len", "length", "ext", "extension",
        "stroke", "enc", "encoder", "displacement"}},
      {Sense::velocity,
       {"qd", "dq", "v", "vel", "velocity", "velocities", "speed", "omega", "w", "qdot", "rate", "qp"}},
      {Sense::acceleration, {"qdd", "ddq", "acc", "accel", "acceleration", "qddot", "qpp"}},
      {Sense::command,
       {"u", "cmd", "command", "commands", "ctrl", "control", "pwm", "duty", "valve", "volt", "voltage", "input",
        "spool"}},
      {Sense::effort, {"tau", "torque", "torques", "trq", "effort", "efforts", "force", "moment", "f"}},
      {Sense::current, {"i", "cur", "curr", "current", "amp", "amps"}},
      {Sense::reference,
       {"ref", "reference", "des", "desired", "target", "setpoint", "sp", "goal", "traj", "trajectory"}},
      {Sense::pressure, {"pressure", "press", "pres", "p"}},
      {Sense::side_a, {"a", "head", "bore", "cap", "piston", "blind"}},
      {Sense::side_b, {"b", "rod", "annulus"}},
      {Sense::motor, {"motor", "mot"}}};
  return kWords;
}

const Words& units() {
  static const Words kUnits{"deg", "degree", "degrees", "rad",     "mm",  "cm",  "m",  "s",   "ms",
                            "us",  "ns",     "sec",     "bar",     "mpa", "kpa", "pa", "psi", "nm",
                            "knm", "kn",     "v",       "percent", "pct", "rpm", "n",  "a",   "ma"};
  return kUnits;
}

bool is_number(const std::string& word) {
  return !word.empty() && word.size() <= 4 &&
         std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// A column while it is understood.
struct Reading {
  std::string column;
  std::vector<std::string> words;
  std::optional<ChannelKind> kind;
  bool current = false, is_effort = false;
  std::string unit, why_unused;
  Words rest;  ///< words that name neither quantity nor unit: they should name the joint
  int joint = -1;
  std::string reason;
  bool sure = true;
};

class Matcher {
 public:
  Matcher(const Robot& robot, const std::vector<std::string>& names)
      : robot_(robot), joints_(words_of_joints(robot)), links_(words_of_moved_links(robot)) {
    for (const std::string& name : names)
      readings_.push_back({name, words_of(name), {}, false, false, "", "", {}, -1, "", true});
  }

  ColumnGuesses run() {
    take_time();
    for (Reading& reading : readings_) {
      find_by_name(reading);
      find_sense(reading);
    }
    recount_from_zero();
    for (Reading& reading : readings_) find_by_number_or_part(reading);
    find_by_elimination();
    // Names that agree come before guesses.
    for (const bool sure : {true, false})
      for (const Reading& reading : readings_)
        if (reading.sure == sure) settle(reading);
    return std::move(out_);
  }

 private:
  std::string joint_name(int joint) const { return robot_.joints()[joint].name; }

  void take_time() {
    static const Words kTime{"t", "time", "timestamp", "stamp", "times", "clock", "elapsed", "sec", "seconds"};
    const auto named = [&](const Reading& reading) {
      return !reading.words.empty() &&
             std::all_of(reading.words.begin(), reading.words.end(),
                         [&](const std::string& w) {
                           return kTime.count(w) > 0 || units().count(w) > 0 || w == "header" || w == "ros";
                         }) &&
             std::any_of(reading.words.begin(), reading.words.end(),
                         [&](const std::string& w) { return kTime.count(w) > 0; });
    };
    const auto at = std::find_if(readings_.begin(), readings_.end(), named);
    if (at == readings_.end()) return;
    out_.time = at->column;
    for (const std::string& word : at->words)
      if (word == "s" || word == "ms" || word == "us" || word == "ns" || word == "sec" || word == "seconds")
        out_.time_unit = word == "sec" || word == "seconds" ? "s" : word;
    readings_.erase(at);
  }

  /// The joint all of whose telling words stand in the column's name; of several the one with most.
  int joint_within(const Words& words, const std::vector<Words>& telling) const {
    int best = -1;
    std::size_t most = 0;
    for (std::size_t j = 0; j < telling.size(); ++j) {
      if (telling[j].empty() || telling[j].size() < most) continue;
      if (!std::includes(words.begin(), words.end(), telling[j].begin(), telling[j].end())) continue;
      best = telling[j].size() == most ? -1 : static_cast<int>(j);
      most = telling[j].size();
    }
    return best;
  }

  void find_by_name(Reading& reading) {
    const Words words(reading.words.begin(), reading.words.end());
    reading.rest = words;
    reading.joint = joint_within(words, joints_);
    const Words* telling = reading.joint >= 0 ? &joints_[reading.joint] : nullptr;
    if (telling != nullptr) {
      reading.reason = "by the joint's name";
    } else if (reading.joint = joint_within(words, links_); reading.joint >= 0) {
      telling = &links_[reading.joint];
      reading.reason = "by the name of the link that the joint moves";
    }
    if (telling == nullptr) return;
    for (const std::string& word : *telling) reading.rest.erase(word);
  }

  /// Takes the words of one sense out of the rest; whether there were any.
  static bool take(Words& rest, Sense sense) {
    bool any = false;
    for (const std::string& word : dictionary().at(sense)) any = rest.erase(word) > 0 || any;
    return any;
  }

  void find_sense(Reading& reading) {
    Words& rest = reading.rest;
    std::map<Sense, bool> has;
    for (const auto& [sense, unused] : dictionary()) {
      if (sense == Sense::side_a || sense == Sense::side_b) continue;
      Words taken = rest;
      has[sense] = take(taken, sense);
    }
    // `v_1` is a speed, `u_1_v` a command in volts.
    const bool other = has[Sense::position] || has[Sense::command] || has[Sense::effort] || has[Sense::current];
    if (other && rest.erase("v") > 0) {
      reading.unit = "v";
      Words taken = rest;
      has[Sense::velocity] = take(taken, Sense::velocity);
    }
    choose_kind(reading, has);
    for (const auto& [sense, present] : has)
      if (present) take(rest, sense);
    if (reading.kind == ChannelKind::pressure_a || reading.kind == ChannelKind::pressure_b)
      take(rest, Sense::side_a), take(rest, Sense::side_b);
    for (auto word = rest.begin(); word != rest.end();) {
      if (units().count(*word) > 0)
        reading.unit = *word, word = rest.erase(word);
      else if (says_nothing(*word))
        word = rest.erase(word);
      else
        ++word;
    }
  }

  void choose_kind(Reading& reading, std::map<Sense, bool>& has) const {
    Words sides = reading.rest;
    const bool a = take(sides, Sense::side_a), b = take(sides, Sense::side_b);
    Words spelled = reading.rest;
    spelled.erase("a"), spelled.erase("b");
    const bool told = take(spelled, Sense::side_a) || take(spelled, Sense::side_b);
    const bool no_other = !has[Sense::position] && !has[Sense::velocity] && !has[Sense::command] &&
                          !has[Sense::effort] && !has[Sense::current];
    if (has[Sense::acceleration])
      reading.why_unused = "an acceleration: found from the positions instead";
    else if (has[Sense::reference])
      reading.why_unused = "what was asked for, not what happened: no channel takes it";
    else if (has[Sense::position] && has[Sense::command])
      reading.why_unused = "a commanded position: the actuator is told something else";
    else if (has[Sense::velocity] && has[Sense::command])
      reading.why_unused = "a commanded speed: use it as the command if the drive is told just this";
    else if (has[Sense::command])
      reading.kind = ChannelKind::command, reading.is_effort = has[Sense::effort];
    else if ((has[Sense::pressure] || told) && a != b && no_other)
      reading.kind = a ? ChannelKind::pressure_a : ChannelKind::pressure_b;
    else if (has[Sense::motor] && has[Sense::position])
      reading.kind = ChannelKind::motor_position;
    else if (has[Sense::current])
      reading.kind = ChannelKind::effort, reading.current = true;
    else if (has[Sense::effort])
      reading.kind = ChannelKind::effort;
    else if (has[Sense::velocity])
      reading.kind = ChannelKind::velocity;
    else if (has[Sense::position])
      reading.kind = ChannelKind::position;
    else if (has[Sense::pressure])
      reading.why_unused = "a pressure of neither side (a, head, bore; b, rod)";
    else if (is_slide_letter(reading))
      reading.kind = ChannelKind::position, reading.sure = false, take_slide_letter(reading);
    else if (names_a_unit(reading.rest))
      reading.kind = ChannelKind::position, reading.sure = false;
    else
      reading.why_unused = "its name says no quantity";
  }

  /// `deg`, `mm`: what is measured in these is a position.
  static bool names_a_unit(const Words& rest) {
    static const Words kPlaces{"deg", "degree", "degrees", "rad", "mm", "cm", "m"};
    return std::any_of(rest.begin(), rest.end(), [](const std::string& word) { return kPlaces.count(word) > 0; });
  }

  /// `x`, `s`, `d` alone are positions of slides.
  bool is_slide_letter(const Reading& reading) const {
    Words rest = reading.rest;
    const bool letter = rest.erase("x") > 0 || rest.erase("s") > 0 || rest.erase("d") > 0;
    const int joint = reading.joint >= 0 ? reading.joint : robot_.dof() == 1 ? 0 : -1;
    return letter && rest.empty() && joint >= 0 && robot_.joints()[joint].prismatic();
  }
  static void take_slide_letter(Reading& reading) { reading.rest.clear(); }

  /// `q0` .. `q5` beside joints that count from 1: the number in a joint's name is then another one.
  void recount_from_zero() {
    std::set<std::string> numbers;
    for (const Words& words : joints_) numbers.insert(words.begin(), words.end());
    if (numbers.count("0") > 0) return;
    std::set<ChannelKind> from_zero;
    for (const Reading& reading : readings_)
      if (reading.kind && reading.joint < 0 && reading.rest == Words{"0"}) from_zero.insert(*reading.kind);
    for (Reading& reading : readings_) {
      if (!reading.kind || from_zero.count(*reading.kind) == 0 || reading.joint < 0) continue;
      const Words& telling = joints_[reading.joint];
      if (telling.size() == 1 && is_number(*telling.begin())) reading.rest = telling, reading.joint = -1;
    }
  }

  void find_by_number_or_part(Reading& reading) {
    if (!reading.kind || reading.joint >= 0) return;
    const auto give = [&](int joint, const std::string& reason) {
      reading.joint = joint, reading.reason = reason, reading.sure = false;
    };
    if (reading.rest.empty()) {
      if (robot_.dof() == 1) give(0, "the robot has one joint"), reading.sure = true;
      return;
    }
    if (const int place = place_in_array(reading.column); place >= 0) {
      if (place < robot_.dof()) give(place, "by its place in the array, in the robot's order of joints");
      return;
    }
    if (reading.rest.size() == 1 && is_number(*reading.rest.begin())) {
      const int number = std::stoi(*reading.rest.begin()) - (counts_from_zero(*reading.kind) ? 0 : 1);
      if (number >= 0 && number < robot_.dof()) give(number, "by its number, in the robot's order of joints");
      return;
    }
    int best = -1, shared = 0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const int count = static_cast<int>(std::count_if(joints_[j].begin(), joints_[j].end(), [&](const std::string& w) {
        return !is_number(w) && reading.rest.count(w) > 0;
      }));
      if (count > shared)
        best = static_cast<int>(j), shared = count;
      else if (count == shared && count > 0)
        best = -1;
    }
    if (best >= 0) give(best, "by a part of the joint's name");
  }

  /// "/valves/data[2]" -> 2, an array in a message counts from 0; -1 for other names.
  static int place_in_array(const std::string& column) {
    const std::size_t open = column.rfind('[');
    if (column.empty() || column.front() != '/' || column.back() != ']' || open == std::string::npos) return -1;
    const std::string digits = column.substr(open + 1, column.size() - open - 2);
    return is_number(digits) ? std::stoi(digits) : -1;
  }

  bool counts_from_zero(ChannelKind kind) const {
    return std::any_of(readings_.begin(), readings_.end(),
                       [&](const Reading& r) { return r.kind == kind && r.rest == Words{"0"}; });
  }

  /// One name left and one joint left, where two other names at least are joints': then they belong together.
  void find_by_elimination() {
    std::map<ChannelKind, std::set<int>> taken;
    for (const Reading& reading : readings_)
      if (reading.kind && reading.joint >= 0) taken[*reading.kind].insert(reading.joint);
    std::map<ChannelKind, std::vector<Reading*>> open;
    for (Reading& reading : readings_)
      if (reading.kind && reading.joint < 0 && !reading.rest.empty()) open[*reading.kind].push_back(&reading);
    for (auto& [kind, list] : open) {
      if (list.size() != 1 || taken[kind].size() < 2 || static_cast<int>(taken[kind].size()) + 1 != robot_.dof())
        continue;
      for (int j = 0; j < robot_.dof(); ++j)
        if (taken[kind].count(j) == 0) list.front()->joint = j;
      list.front()->reason = "the only joint left for the only name left";
      list.front()->sure = false;
    }
  }

  void settle(const Reading& reading) {
    if (!reading.kind) {
      out_.unused.push_back({reading.column, reading.why_unused, false});
    } else if (reading.joint < 0) {
      out_.unused.push_back(
          {reading.column, fmt::format("looks like a {}, but of which joint?", to_string(*reading.kind)), true});
    } else if (const ColumnGuess* other = out_.find(*reading.kind, reading.joint)) {
      out_.unused.push_back({reading.column,
                             fmt::format("another {} of {}; {} came first", to_string(*reading.kind),
                                         printable(joint_name(reading.joint), 60), printable(other->column, 60)),
                             false});
    } else {
      out_.columns.push_back({reading.column, *reading.kind, reading.joint, reading.current, reading.is_effort,
                              reading.unit, reading.reason, reading.sure});
    }
  }

  const Robot& robot_;
  std::vector<Words> joints_, links_;
  std::vector<Reading> readings_;
  ColumnGuesses out_;
};

}  // namespace

const ColumnGuess* ColumnGuesses::find(ChannelKind kind, int joint) const {
  const auto at = std::find_if(columns.begin(), columns.end(),
                               [&](const ColumnGuess& guess) { return guess.kind == kind && guess.joint == joint; });
  return at == columns.end() ? nullptr : &*at;
}

ColumnUse use_of(const ColumnGuesses& guesses) {
  ColumnUse out;
  for (const ColumnGuess& guess : guesses.columns)
    (guess.kind == ChannelKind::command ? out.commands : out.measured).insert(guess.column);
  return out;
}

ColumnGuesses match_columns(const Robot& robot, const std::vector<std::string>& names) {
  return Matcher(robot, names).run();
}

}  // namespace lacuna
