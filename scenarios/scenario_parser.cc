#include "scenarios/scenario_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/learned_entry.h"
#include "scenarios/mjcf.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

const char* const kScenarioFormat = "lacuna-scenario/1";
constexpr std::array kKinds{ChannelKind::command,   ChannelKind::position,       ChannelKind::velocity,
                            ChannelKind::effort,    ChannelKind::motor_position, ChannelKind::pressure_a,
                            ChannelKind::pressure_b};
constexpr std::size_t kMaxParts = 64;  // files beside a recording's first
constexpr double kFirstGuess = 1.0;    // kg, of a load whose mass is not given
constexpr std::array kRoles{Role::train, Role::validate, Role::test};

double value_of_parameter(const YamlCursor& cursor) {
  if (!cursor.is_map()) return cursor.number();
  cursor.expect_keys({"value", "ci95", "unit", "probability"});
  return cursor.at("value").number();
}

std::vector<std::string> joint_names(const Robot& robot) {
  std::vector<std::string> names;
  for (const Joint& joint : robot.joints()) names.push_back(joint.name);
  return names;
}

/// A path in a scenario: relative or absolute, but within the scenario's folder tree once symlinks are resolved.
std::string inner_path(const YamlCursor& cursor, const Scenario& scenario) {
  std::string written = cursor.text();
  if (!inside(scenario.folder(), resolve(scenario, written)))
    cursor.fail("a file in the scenario's folder or below it");
  return written;
}

/// `stamps` of a bag: whose times its clock is made of.
bool takes_log_times(const YamlCursor& entry) {
  const auto stamps = entry.find("stamps");
  if (!stamps) return false;
  const std::string word = stamps->text();
  if (word != "log" && word != "header") stamps->fail("header or log");
  return word == "log";
}

}  // namespace

std::filesystem::path resolve(const Scenario& scenario, const std::string& written) {
  return (scenario.folder() / written).lexically_normal();
}

void ScenarioParser::parse() {
  parse_head();
  parse_robot();
  const auto section = [&](const char* key, void (ScenarioParser::*read)(const YamlCursor&)) {
    if (const auto cursor = root_.find(key)) (this->*read)(*cursor);
  };
  section("actuators", &ScenarioParser::parse_actuators);
  section("identify", &ScenarioParser::parse_identify);
  section("channels", &ScenarioParser::parse_channels);
  section("noise", &ScenarioParser::parse_noise);
  section("recordings", &ScenarioParser::parse_recordings);
  section("effects", &ScenarioParser::parse_effects);
  section("payloads", &ScenarioParser::parse_payloads);
  section("prediction", &ScenarioParser::parse_prediction);
  section("motion", &ScenarioParser::parse_motion);
  note_unused();
}

void ScenarioParser::parse_head() {
  root_.expect_keys({"format", "name", "robot", "gravity", "sample_period", "total_mass", "actuators", "identify",
                     "channels", "noise", "recordings", "effects", "payloads", "prediction", "motion"});
  const YamlCursor format = root_.at("format");
  if (format.text() != kScenarioFormat) format.fail(kScenarioFormat);
  out_.name = root_.at("name").text();
  if (const auto gravity = root_.find("gravity")) {
    const auto parts = gravity->items();
    if (parts.size() != 3) gravity->fail("three numbers [x, y, z], m/s^2");
    for (int i = 0; i < 3; ++i) out_.gravity[i] = parts[i].number();
  }
  if (const auto period = root_.find("sample_period")) out_.sample_period = period->positive_number();
  if (const auto mass = root_.find("total_mass")) out_.total_mass = mass->positive_number();
}

void ScenarioParser::parse_robot() {
  const YamlCursor cursor = root_.at("robot");
  out_.robot_file = cursor.text();
  const auto path = resolve(out_, out_.robot_file);
  if (!is_there(path)) cursor.fail("a URDF or MJCF file that exists");
  std::vector<std::string> notes;
  MjcfModel model = read_robot_file(path, &notes);
  out_.robot = model.robot, out_.actuators = std::move(model.actuators), out_.effects = std::move(model.effects);
  if (!root_.find("gravity")) out_.gravity = model.gravity;
  for (const std::string& note : notes) out_.notes.push_back(printable(out_.robot_file) + ": " + note);
}

void ScenarioParser::expect_joint(const std::string& name, const YamlCursor& at) const {
  if (!out_.robot->find_joint(name))
    throw InputError(at.where(), "the joint " + quoted(name) + ", which the robot does not have",
                     one_of(joint_names(*out_.robot)));
}

void ScenarioParser::parse_actuators(const YamlCursor& section) {
  for (const auto& [joint, cursor] : section.entries()) {
    expect_joint(joint, cursor);
    ActuatorSpec spec;
    spec.joint = joint;
    spec.where = cursor.where();
    // What the scenario says of a joint stands before what the robot's file says.
    std::erase_if(out_.actuators, [&](const ActuatorSpec& given) { return given.joint == spec.joint; });
    std::erase_if(out_.effects, [&](const EffectSpec& given) {  // of that actuator's command
      return given.place == spec.joint && (given.effect == "valve_offset" || given.effect == "actuator_lag");
    });
    spec.model = cursor.at("model").text();
    for (const auto& [key, value] : cursor.entries())
      if (key != "model") spec.parameters[key] = value.number();
    out_.actuators.push_back(std::move(spec));
  }
}

void ScenarioParser::parse_identify(const YamlCursor& section) {
  for (const auto& [name, cursor] : section.entries()) {
    IdentifySpec spec;
    spec.name = name;
    spec.where = cursor.where();
    YamlCursor bounds = cursor;
    if (!cursor.is_list()) {
      cursor.expect_keys({"bounds", "relative_bounds"});
      const auto absolute = cursor.find("bounds");
      const auto relative = cursor.find("relative_bounds");
      if (absolute.has_value() == relative.has_value())
        throw InputError(cursor.where(), absolute ? "both bounds and relative_bounds" : "no bounds",
                         "either bounds or relative_bounds");
      spec.relative = relative.has_value();
      bounds = spec.relative ? *relative : *absolute;
    }
    std::tie(spec.lower, spec.upper) = bounds.range();
    out_.identify.push_back(std::move(spec));
  }
}

void ScenarioParser::parse_channels(const YamlCursor& section) {
  std::vector<std::string> keys{"time"};
  for (const ChannelKind kind : kKinds) keys.emplace_back(to_string(kind));
  section.expect_keys(keys);
  if (const auto time = section.find("time")) out_.channels.time = time->text();
  for (const ChannelKind kind : kKinds)
    if (const auto cursor = section.find(to_string(kind))) parse_kind(kind, *cursor);
  refuse_shared_columns();
}

void ScenarioParser::parse_kind(ChannelKind kind, const YamlCursor& section) {
  for (const auto& [joint, cursor] : section.entries()) {
    expect_joint(joint, cursor);
    ColumnSpec spec;
    spec.where = cursor.where();
    if (cursor.is_map()) {
      cursor.expect_keys({"column", "scale", "offset", "unit"});
      spec.column = cursor.at("column").text();
      if (const auto scale = cursor.find("scale")) {
        spec.scale = scale->number();
        if (spec.scale == 0.0) scale->fail("a factor that is not 0");
      }
      if (const auto offset = cursor.find("offset")) spec.offset = offset->number();
      if (const auto unit = cursor.find("unit")) {
        spec.unit = unit->text();
        if (kind != ChannelKind::command) unit->fail("a unit of commands only; what is measured is SI");
        if (spec.unit.empty()) unit->fail("a unit, as V or \"%\"");
      }
    } else if (cursor.is_scalar()) {
      spec.column = cursor.text();
    } else {
      cursor.fail("a column name or {column, scale, offset, unit}");
    }
    if (spec.column == out_.channels.time)
      throw InputError(spec.where, "the time column " + quoted(spec.column),
                       "a column of the " + std::string(to_string(kind)));
    out_.channels.of[kind].emplace(joint, std::move(spec));
  }
}

/// A measured column belongs to one joint and one kind; one command may drive several joints.
void ScenarioParser::refuse_shared_columns() const {
  std::map<std::string, std::string> users;
  for (const auto& [kind, joints] : out_.channels.of) {
    if (kind == ChannelKind::command || kind == ChannelKind::effort) continue;
    for (const auto& [joint, spec] : joints) {
      const std::string user = std::string(to_string(kind)) + " of " + printable(joint, 60);
      const auto [first, fresh] = users.emplace(spec.column, user);
      if (!fresh)
        throw InputError(spec.where, "the column " + quoted(spec.column) + ", already the " + first->second,
                         "a column of its own");
    }
  }
}

void ScenarioParser::parse_noise(const YamlCursor& section) {
  std::vector<std::string> keys;
  for (const ChannelKind kind : kKinds)
    if (kind != ChannelKind::command) keys.emplace_back(to_string(kind));
  section.expect_keys(keys);
  for (const ChannelKind kind : kKinds) {
    const auto cursor = section.find(to_string(kind));
    if (!cursor) continue;
    const auto channels = out_.channels.of.find(kind);
    if (channels == out_.channels.of.end())
      throw InputError(cursor->where(), "noise of a kind without channels",
                       fmt::format("channels.{} to be given too", to_string(kind)));
    auto& noise = out_.noise[kind];
    if (!cursor->is_map()) {
      for (const auto& [joint, unused] : channels->second) noise[joint] = cursor->positive_number();
      continue;
    }
    for (const auto& [joint, value] : cursor->entries()) {
      expect_joint(joint, value);
      if (channels->second.count(joint) == 0)
        throw InputError(value.where(), "noise of a joint without that channel",
                         fmt::format("channels.{} of {} to be given too", to_string(kind), printable(joint, 60)));
      noise[joint] = value.positive_number();
    }
  }
}

/// One more file of a recording: its name, or a map.
RecordingPart ScenarioParser::parse_part(const YamlCursor& entry) const {
  RecordingPart part;
  if (entry.is_scalar()) {
    part.file = inner_path(entry, out_);
    return part;
  }
  if (!entry.is_map()) entry.fail("a file, or {file, clock_offset, time, prefix, stamps}");
  entry.expect_keys({"file", "clock_offset", "time", "prefix", "stamps"});
  part.file = inner_path(entry.at("file"), out_);
  if (const auto offset = entry.find("clock_offset")) part.clock_offset = offset->number();
  if (const auto time = entry.find("time")) part.time = time->text();
  if (const auto prefix = entry.find("prefix")) part.prefix = prefix->text();
  part.log_times = takes_log_times(entry);
  return part;
}

RecordingSpec ScenarioParser::parse_recording(const YamlCursor& entry) const {
  entry.expect_keys({"file", "role", "from", "to", "with", "stamps"});
  RecordingSpec spec;
  spec.where = entry.where();
  spec.file = inner_path(entry.at("file"), out_);
  const YamlCursor role = entry.at("role");
  const std::string written = role.text();
  const auto found = std::find_if(kRoles.begin(), kRoles.end(), [&](Role r) { return written == to_string(r); });
  if (found == kRoles.end()) role.fail("train, validate or test");
  spec.role = *found;
  if (const auto from = entry.find("from")) spec.from = from->number();
  if (const auto to = entry.find("to")) spec.to = to->number();
  spec.log_times = takes_log_times(entry);
  if (const auto with = entry.find("with"))
    for (const YamlCursor& item : with->items()) {
      if (spec.with.size() == kMaxParts) item.fail(fmt::format("at most {} further files", kMaxParts));
      spec.with.push_back(parse_part(item));
    }
  if (spec.from && spec.to && !(*spec.from < *spec.to))
    throw InputError(spec.where, fmt::format("from {} to {}", format_number(*spec.from), format_number(*spec.to)),
                     "from before to");
  return spec;
}

void ScenarioParser::parse_recordings(const YamlCursor& section) {
  const auto entries = section.items();
  if (!entries.empty() && out_.channels.of.count(ChannelKind::position) == 0)
    throw InputError(section.where(), "recordings but no channels.position", "the columns of the measured positions");
  for (const YamlCursor& entry : entries) {
    RecordingSpec spec = parse_recording(entry);
    for (const RecordingSpec& other : out_.recordings)
      if (other.file == spec.file && (other.log_times != spec.log_times || other.with != spec.with))
        throw InputError(spec.where, quoted(spec.file) + " with other files, offsets or stamps than before",
                         "the same wherever it is listed: it is one recording");
    for (const RecordingSpec& other : out_.recordings)
      if (other.file == spec.file && other.role == spec.role && other.from == spec.from && other.to == spec.to)
        throw InputError(spec.where, quoted(spec.file) + " a second time with the same role and range", "it once");
    out_.recordings.push_back(std::move(spec));
  }
  note_overlaps();
}

/// What was fitted is no proof: say so where one stretch serves for fitting and for judging.
void ScenarioParser::note_overlaps() {
  constexpr double kEnd = std::numeric_limits<double>::infinity();
  std::set<std::string> notes;
  for (std::size_t i = 0; i < out_.recordings.size(); ++i)
    for (std::size_t j = i + 1; j < out_.recordings.size(); ++j) {
      const RecordingSpec &a = out_.recordings[i], &b = out_.recordings[j];
      if (a.file != b.file || a.role == b.role) continue;
      if (std::max(a.from.value_or(-kEnd), b.from.value_or(-kEnd)) >=
          std::min(a.to.value_or(kEnd), b.to.value_or(kEnd)))
        continue;
      const auto [first, second] = std::minmax(a.role, b.role);
      notes.insert(
          fmt::format("{}: the {} and {} ranges overlap", printable(a.file), to_string(first), to_string(second)));
    }
  out_.notes.insert(out_.notes.end(), notes.begin(), notes.end());
}

void ScenarioParser::expect_recording(const std::string& file, const YamlCursor& at) const {
  const bool known = std::any_of(out_.recordings.begin(), out_.recordings.end(),
                                 [&](const RecordingSpec& recording) { return recording.file == file; });
  if (!known) at.fail("a file listed under recordings");
}

EffectSpec ScenarioParser::parse_effect(const YamlCursor& entry) const {
  entry.expect_keys(
      {"effect", "where", "parameters", "recordings", "probability", "over", "knots", "values", "period"});
  EffectSpec spec;
  spec.where = entry.where();
  spec.effect = entry.at("effect").text();
  if (is_learned(spec.effect)) {
    if (const auto parameters = entry.find("parameters")) parameters->fail("over, knots and values instead");
    spec.parameters = parse_curve(entry, *out_.robot);
  } else {
    for (const char* key : {"over", "knots", "values", "period"})
      if (const auto given = entry.find(key)) given->fail("nothing: only learned effects take it");
  }
  const YamlCursor place = entry.at("where");
  spec.place = place.text();
  if (spec.place != "arm") expect_joint(spec.place, place);
  if (const auto parameters = entry.find("parameters"))
    for (const auto& [name, value] : parameters->entries()) spec.parameters[name] = value_of_parameter(value);
  if (const auto recordings = entry.find("recordings"))
    for (const YamlCursor& item : recordings->items()) {
      const std::string file = item.text();
      expect_recording(file, item);
      if (std::find(spec.recordings.begin(), spec.recordings.end(), file) != spec.recordings.end())
        item.fail("each recording once");
      spec.recordings.push_back(file);
    }
  return spec;
}

void ScenarioParser::parse_events(const YamlCursor& entry, EventSpec::Kind kind) {
  entry.expect_keys({"effect", "where", "events", "probability"});
  const YamlCursor place = entry.at("where");
  EventSpec spec{kind, place.text(), "", 0.0, 0.0, 0.0, 0.0, ""};
  expect_joint(spec.joint, place);
  const YamlCursor events = entry.at("events");
  if (events.items().empty()) events.fail("at least one event");
  for (const YamlCursor& item : events.items()) {
    item.expect_keys({"recording", "from", "to", "value", "rise"});
    spec.where = item.where();
    spec.file = item.at("recording").text();
    expect_recording(spec.file, item.at("recording"));
    spec.from = item.at("from").number(), spec.to = item.at("to").number();
    if (!(spec.from < spec.to)) item.at("to").fail(fmt::format("s, after from ({})", format_number(spec.from)));
    spec.value = item.at("value").number();
    const auto rise = item.find("rise");
    spec.rise = rise ? rise->number() : 0.0;
    if (rise && kind != EventSpec::Kind::effort) rise->fail("nothing: only learned_effort takes it");
    if (!(spec.rise >= 0.0 && spec.rise <= 0.5 * (spec.to - spec.from))) rise->fail("s, from 0 to half of the event");
    out_.events.push_back(spec);
  }
}

/// What was learned of single instants stands beside what is learned of the machine.
void ScenarioParser::parse_effects(const YamlCursor& section) {
  using Kind = EventSpec::Kind;
  std::vector<EffectSpec> stated, &from_robot = out_.effects;
  for (const YamlCursor& entry : section.items()) {
    const std::string effect = entry.at("effect").text();
    const auto kinds = {Kind::effort, Kind::command, Kind::reading};
    const auto kind = std::ranges::find_if(kinds, [&](Kind k) { return effect == to_string(k); });
    if (kind != kinds.end() && entry.find("events")) {
      parse_events(entry, *kind);
      continue;
    }
    EffectSpec spec = parse_effect(entry);
    std::erase_if(from_robot,
                  [&](const EffectSpec& given) { return given.effect == spec.effect && given.place == spec.place; });
    stated.push_back(std::move(spec));
  }
  from_robot.insert(from_robot.end(), stated.begin(), stated.end());
}

/// Loads carried in some recordings: a payload effect each. One without a mass is free, to be identified.
void ScenarioParser::parse_payloads(const YamlCursor& section) {
  for (const YamlCursor& entry : section.items()) {
    entry.expect_keys({"name", "mass", "place", "recordings"});
    EffectSpec spec;
    spec.where = entry.where();
    spec.effect = "payload";
    spec.place = "arm";
    entry.at("name").text();  // for people
    const std::size_t before = std::count_if(out_.effects.begin(), out_.effects.end(),
                                             [](const EffectSpec& e) { return e.effect == "payload"; });
    const auto mass = entry.find("mass");
    spec.parameters["m"] = mass ? mass->positive_number() : kFirstGuess;
    if (const auto place = entry.find("place")) {
      const auto parts = place->items();
      if (parts.size() != 3) place->fail("three numbers [x, y, z], m from the tool's origin");
      const char* const axes[] = {"x", "y", "z"};
      for (std::size_t i = 0; i < 3; ++i) spec.parameters[axes[i]] = parts[i].number();
    }
    for (const YamlCursor& item : entry.at("recordings").items()) {
      const std::string file = item.text();
      expect_recording(file, item);
      spec.recordings.push_back(file);
    }
    if (!mass) {
      const std::string again = before > 0 ? fmt::format("#{}", before + 1) : "";
      out_.identify.push_back({"arm.payload" + again + ".m", false, 0.0, 2.0 * out_.robot->moving_mass(), spec.where});
    }
    out_.effects.push_back(std::move(spec));
  }
}

/// Whether pressures act in the actuator: it has chambers (which models have is not known here).
bool has_areas(const ActuatorSpec& actuator) { return actuator.parameters.contains("area_a"); }

/// A pressure is used where the joint's actuator has areas, and motions are simulated.
void ScenarioParser::note_unused_pressures() {
  const bool simulated = !std::holds_alternative<InverseDynamics>(out_.prediction);
  const auto has_piston = [&](const std::string& joint) {
    return std::ranges::any_of(out_.actuators, [&](const ActuatorSpec& a) { return a.joint == joint && has_areas(a); });
  };
  for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b}) {
    const auto channels = out_.channels.of.find(kind);
    if (channels == out_.channels.of.end()) continue;
    for (const auto& [joint, unused] : channels->second) {
      if (simulated && has_piston(joint)) continue;
      out_.notes.push_back(fmt::format(
          "channels.{} of {}: read and checked, but not {}", to_string(kind), printable(joint, 60),
          simulated ? "predicted, which only a hydraulic actuator does: a diagnosis holds its chain against it"
                    : "used: inverse dynamics predicts no pressure"));
    }
  }
}

/// Where measured pressures push a piston, what its valve was told has had its say in them.
void ScenarioParser::note_commands_before_pressures() {
  const auto commands = out_.channels.of.find(ChannelKind::command);
  if (!out_.pressure_driven || commands == out_.channels.of.end()) return;
  for (const ActuatorSpec& actuator : out_.actuators)
    if (has_areas(actuator) && commands->second.contains(actuator.joint))
      out_.notes.push_back("channels.command of " + printable(actuator.joint, 60) +
                           ": not used, since the joint is driven by its measured pressures");
}

/// Nothing given is ignored in silence.
void ScenarioParser::note_unused() {
  note_unused_pressures();
  note_commands_before_pressures();
  const auto commands = out_.channels.of.find(ChannelKind::command),
             efforts = out_.channels.of.find(ChannelKind::effort);
  if (!std::holds_alternative<InverseDynamics>(out_.prediction) || commands == out_.channels.of.end() ||
      efforts == out_.channels.of.end())
    return;
  for (const auto& [joint, unused] : commands->second)
    if (efforts->second.count(joint) > 0)
      out_.notes.push_back("channels.command of " + printable(joint, 60) +
                           ": not used by inverse dynamics, since its effort is measured");
}

void ScenarioParser::parse_prediction(const YamlCursor& section) {
  constexpr const char* kForms =
      "free_run, {horizon: s}, {inverse_dynamics: {cutoff_hz: Hz}} or {pressure_driven: free_run or {horizon: s}}";
  if (section.is_scalar()) {
    if (section.text() != "free_run") section.fail(kForms);
    out_.prediction = FreeRun{};
    return;
  }
  section.expect_keys({"horizon", "inverse_dynamics", "pressure_driven"});
  const auto horizon = section.find("horizon");
  const auto inverse = section.find("inverse_dynamics");
  const auto pressures = section.find("pressure_driven");
  if (horizon.has_value() + inverse.has_value() + pressures.has_value() != 1) section.fail(kForms);
  if (horizon) {
    out_.prediction = Windows{horizon->positive_number()};
  } else if (inverse) {
    inverse->expect_keys({"cutoff_hz"});
    out_.prediction = InverseDynamics{inverse->at("cutoff_hz").positive_number()};
  } else {
    parse_pressure_driven(*pressures);
  }
}

/// `free_run` or `{horizon: s}`, where every valve's both pressures are measured.
void ScenarioParser::parse_pressure_driven(const YamlCursor& section) {
  out_.pressure_driven = true;
  if (!section.is_scalar()) {
    section.expect_keys({"horizon"});
    if (const auto horizon = section.find("horizon")) out_.prediction = Windows{horizon->positive_number()};
  } else if (section.text() != "free_run") {
    section.fail("free_run or {horizon: s}");
  }
  int driven = 0;
  for (const ActuatorSpec& actuator : out_.actuators) {
    if (!has_areas(actuator)) continue;
    ++driven;
    for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b})
      if (const auto of = out_.channels.of.find(kind);
          of == out_.channels.of.end() || !of->second.contains(actuator.joint))
        throw InputError(section.where(), fmt::format("no channels.{} of {}", to_string(kind), quoted(actuator.joint)),
                         "both pressures of every joint with a hydraulic actuator");
  }
  if (driven == 0) section.fail("an actuator of the model hydraulic, whose areas the measured pressures act on");
}

void ScenarioParser::parse_motion(const YamlCursor& section) {
  section.expect_keys({"duration", "position", "velocity", "commands", "pickup"});
  MotionSpec motion;
  motion.where = section.where();
  if (const auto duration = section.find("duration")) motion.duration = duration->positive_number();
  for (auto [key, values] : {std::pair("position", &motion.position), std::pair("velocity", &motion.velocity)}) {
    const auto cursor = section.find(key);
    if (!cursor) continue;
    for (const auto& [joint, value] : cursor->entries()) {
      expect_joint(joint, value);
      (*values)[joint] = value.number();
    }
  }
  if (const auto commands = section.find("commands")) {
    if (out_.channels.time.empty() || out_.channels.of.count(ChannelKind::command) == 0)
      throw InputError(commands->where(), "commands but no channels.time or channels.command",
                       "the columns of the time and of each joint's command");
    motion.commands = inner_path(*commands, out_);
  }
  if (const auto pickup = section.find("pickup")) {
    pickup->expect_keys({"mass", "time"});
    motion.pickup_mass = pickup->at("mass").positive_number();
    motion.pickup_time = pickup->at("time").positive_number();
  }
  out_.motion = std::move(motion);
}

}  // namespace lacuna
