// A scenario: one robot, how it is driven, what was recorded, what shall be identified (`scenario.yaml`).
//
// This room checks form: keys, types, names of joints, links, columns and files. Which actuator models, effects and
// parameters exist is known upstairs (physics/), which reports against the `where` kept with every entry.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scenarios/recording.h"
#include "scenarios/robot.h"

namespace lacuna {

/// `model` and its parameters, for one joint.
struct ActuatorSpec {
  std::string joint;
  std::string model;
  std::map<std::string, double> parameters;
  std::string where;  ///< "file:line: key", for messages
};

/// One physical effect at one place, as a diagnosis writes it:
/// `{effect: coulomb_friction, where: joint_2, parameters: {Fc: 24.7}, recordings: [train_1.csv]}`.
/// A parameter may also be a map with a `value` (what diagnosis.json holds).
struct EffectSpec {
  std::string effect;
  std::string place;  ///< joint name or "arm"
  std::map<std::string, double> parameters;
  std::vector<std::string> recordings;  ///< files in which it acts; empty: in all
  std::string where;
};

/// What happened once in a recording and is no part of the machine, as a diagnosis writes it:
/// `{effect: learned_effort, where: joint_2, events: [{recording: train_1.csv, from: 6.1, to: 6.6, value: 1.2}]}`.
struct EventSpec {
  enum class Kind {
    effort,   ///< `learned_effort`, a push: N m (N) on the joint besides all else
    command,  ///< `learned_command`, lost or repeated: what arrived in place of what is recorded, command's unit
    reading   ///< `learned_reading`, a slip of the position's transducer: rad (m) on top of what it would read
  };
  Kind kind = Kind::effort;
  std::string joint, file;      ///< recording's, as written
  double from = 0.0, to = 0.0;  ///< s, on the recording's own clock
  double value = 0.0;
  double rise = 0.0;  ///< s, in which an effort comes and goes, within `from` and `to`
  std::string where;
};
/// The effect's name in a scenario ("learned_effort").
const char* to_string(EventSpec::Kind kind);

/// Which parameters are free. `name` is a kind ("gain": that parameter of every joint; "mass": of every moving link)
/// or one full name ("joint_2.gain", "link_3.mass", "joint_2.coulomb_friction.Fc").
struct IdentifySpec {
  std::string name;
  bool relative = false;  ///< bounds are factors of the start value
  double lower = 0.0, upper = 0.0;
  std::string where;
};

/// Column of a recording: value = scale * column + offset.
struct ColumnSpec {
  std::string column;
  double scale = 1.0;
  double offset = 0.0;
  std::string where;
  std::string unit = {};  ///< of a command's value, as written; empty: not said. What is measured is SI
};

enum class ChannelKind { command, position, velocity, effort, motor_position, pressure_a, pressure_b };
const char* to_string(ChannelKind kind);

/// Columns of every joint; joints without a channel of a kind are absent from its map.
struct ChannelSpecs {
  std::string time;
  std::map<ChannelKind, std::map<std::string, ColumnSpec>> of;  ///< kind -> joint name -> column
};

enum class Role { train, validate, test };
const char* to_string(Role role);

struct RecordingSpec {
  std::string file;  ///< as written
  Role role = Role::train;
  std::optional<double> from, to;         ///< s, on the recording's own clock
  std::shared_ptr<const Recording> data;  ///< one load per file, shared
  std::string where;
  bool log_times = false;             ///< `stamps: log`, of a bag: times of receipt in place of headers'
  std::vector<RecordingPart> with{};  ///< further files of the same motion, brought onto this one's clock
};

/// What is compared with the recording.
struct FreeRun {};  ///< one simulation from the start
struct Windows {
  double horizon = 0.0;
};  ///< s; each started from the measured state
struct InverseDynamics {
  double cutoff_hz = 0.0;
};  ///< effort needed for the measured, low-passed motion
using Prediction = std::variant<FreeRun, Windows, InverseDynamics>;

/// What `lacuna compare` moves where no recording says so, or in its place:
/// `{duration: 5, position: {shoulder: 2.0}, velocity: {elbow: 1.0}, commands: steps.csv, pickup: {mass: 8,
/// time: 1.5}}`.
struct MotionSpec {
  std::optional<double> duration;          ///< s
  std::map<std::string, double> position;  ///< rad (m) at the start, by joint; others 0
  std::map<std::string, double> velocity;  ///< rad/s (m/s) at the start; others 0
  std::string commands;                    ///< file as written, with the time and command columns; "": none
  std::optional<double> pickup_mass;       ///< kg, a point mass at rest that the tool takes hold of,
  double pickup_time = 0.0;                ///< s, at this instant
  std::string where;
};

struct Scenario {
  std::filesystem::path file;  ///< as given
  std::string name;
  std::string robot_file;  ///< as written, relative to the scenario
  std::shared_ptr<const Robot> robot;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< m/s^2, world frame
  std::optional<double> sample_period;       ///< s; absent: irregular clocks
  std::optional<double> total_mass;          ///< kg, known sum over the moving links
  std::vector<ActuatorSpec> actuators;       ///< at most one per joint; joints without one are passive
  std::vector<IdentifySpec> identify;
  ChannelSpecs channels;
  std::map<ChannelKind, std::map<std::string, double>>
      noise;  ///< rms in channel units, per kind and joint; absent: estimated
  std::vector<RecordingSpec> recordings;
  std::vector<EffectSpec> effects;
  std::vector<EventSpec> events;
  Prediction prediction = FreeRun{};
  /// Simulations of joints with a hydraulic actuator start behind the valve: the measured pressures push the pistons.
  bool pressure_driven = false;
  std::optional<MotionSpec> motion;
  std::vector<std::string> notes;  ///< what loading ignored or counted (meshes, missing samples)

  std::filesystem::path folder() const { return file.parent_path(); }
};

struct ScenarioOptions {
  bool load_recordings = true;  ///< off: recordings' `data` stay empty (render, export, engines)
};

/// Loads and checks everything; throws InputError. Unknown or duplicate keys, wrong types, unknown joints, links or
/// columns, missing files, paths that leave the scenario's folder tree (except `robot`; symlinks resolved), NaN or
/// missing time or command inside [from, to], time that does not increase, positions missing altogether: all are
/// errors. With `sample_period`, clocks that differ from it by over 1 % are an error.
Scenario load_scenario(const std::filesystem::path& file, const ScenarioOptions& options = {});

/// Writes a scenario that loads to the same values (used for `scenario.diagnosed.yaml`). Paths are rewritten relative
/// to the new file's folder. Throws WriteError when it cannot be written.
void save_scenario(const Scenario& scenario, const std::filesystem::path& file);

/// URDF text of the robot with `link_masses` (kg, one per link) put in; inertias scale with mass.
std::string to_urdf(const Robot& robot, std::span<const double> link_masses = {});

}  // namespace lacuna
