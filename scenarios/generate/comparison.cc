// scenarios/compare/: one folder a scenario, each complete in itself, to be run by `lacuna compare` and to be copied.
#include <fmt/format.h>

#include <functional>

#include "scenarios/generate/bundle.h"

namespace lacuna::generate {
namespace {

const std::vector<int> kSeven{1, 2, 3, 4, 5, 6, 7};
constexpr int kCommandSamples = 401;  // 4 s

using Values = std::vector<std::pair<const char*, double>>;
using Body = std::function<void(YamlWriter&)>;

/// A folder with its robot. `body` writes the scenario after its head.
void add_folder(Files& files, const std::string& name, const Robot& robot, const std::string& comment,
                const Body& body) {
  YamlWriter yaml(kCommentColumn);
  yaml.remark(comment).remark("Written by lacuna_generate_scenarios; change scenarios/generate/comparison.cc.");
  yaml.map().put("format", "lacuna-scenario/1").put("name", name).put("robot", "robot.urdf");
  yaml.put("gravity", {0.0, 0.0, -9.81});
  body(yaml);
  add(files, "compare/" + name + "/scenario.yaml", yaml);
  files["compare/" + name + "/robot.urdf"] = commented_urdf(robot, comment);
}

void put_values(YamlWriter& yaml, const char* key, const Values& values) {
  if (values.empty()) return;
  yaml.key(key).short_map();
  for (const auto& [name, value] : values) yaml.put(name, value);
  yaml.end();
}

struct MotionEntry {
  double duration;  ///< s
  Values position, velocity;
  bool commanded = false;  ///< by commands.csv
  Values pickup = {};
};

void put_motion(YamlWriter& yaml, const MotionEntry& motion, const char* units) {
  yaml.key("motion").short_map();
  if (motion.commanded) yaml.put("commands", "commands.csv");
  yaml.put("duration", motion.duration);
  put_values(yaml, "position", motion.position);
  put_values(yaml, "velocity", motion.velocity);
  put_values(yaml, "pickup", motion.pickup);
  yaml.end().comment(units);
}

/// The seven-function arm under one excitation.
void add_arm(Files& files, const std::string& course, const std::string& comment, const Body& extra = {}) {
  const std::string name = "arm_" + course;
  add_folder(files, name, *hydrolek(), comment, [&](YamlWriter& yaml) {
    put_actuators(yaml, start_sources());
    if (extra) extra(yaml);
    yaml.key("channels").map().put("time", "t").comment("s");
    put_commands(yaml, kSeven);
    yaml.end();
    put_motion(
        yaml,
        {4, {{"joint_2", 0.4}, {"joint_3", -0.8}, {"joint_4", 0.3}, {"joint_5", 0.3}, {"joint_7", 0.05}}, {}, true},
        "s, rad, m");
  });
  files["compare/" + name + "/commands.csv"] = command_table(course, kSeven, kCommandSamples);
}

void add_arms(Files& files) {
  add_arm(files, "step", "The hydraulic arm: one step at every joint.");
  add_arm(files, "multisine", "The hydraulic arm: multisines at every joint. What is identified on every engine.",
          [](YamlWriter& yaml) {
            yaml.key("identify").map();
            for (const char* parameter : {"gain", "damping", "stiffness"}) put_factors(yaml, parameter, 0.5, 2.0);
            yaml.end();
          });
  add_arm(files, "staircase", "The hydraulic arm: a staircase of commands at every joint.");
}

void add_seed_arms(Files& files) {
  std::vector<Source> sources = start_sources();
  sources.pop_back();
  add_folder(
      files, "pickup", *seed_arm("pickup_arm", kTable1Masses),
      "The arm swings to its rest angles and takes hold of a load on its way.", [&](YamlWriter& yaml) {
        put_actuators(yaml, sources);
        put_motion(
            yaml,
            {2.4, {{"joint_2", 0.9}, {"joint_3", -0.2}, {"joint_5", 0.6}}, {}, false, {{"mass", 8}, {"time", 0.6}}},
            "s, rad, kg");
      });
  sources.pop_back();
  add_folder(
      files, "spinning_wrist", *skew_arm(),
      "The wrist spins with a load off its axis, principal axes askew: gyroscopic terms.", [&](YamlWriter& yaml) {
        put_actuators(yaml, sources);
        put_motion(yaml,
                   {2, {{"joint_2", 0.4}, {"joint_3", -0.8}, {"joint_4", 0.3}, {"joint_5", 0.3}}, {{"joint_6", 40}}},
                   "s, rad, rad/s");
      });
  add_folder(
      files, "free_swing", *seed_arm("free_arm", kTable1Masses),
      "The arm let go from a stretched pose, nothing drives or brakes it: its energy must stay.", [](YamlWriter& yaml) {
        put_motion(yaml,
                   {3, {{"joint_1", 0.2}, {"joint_2", 0.6}, {"joint_3", -0.4}, {"joint_4", 0.3}, {"joint_5", 0.4}}, {}},
                   "s, rad");
      });
}

void add_stick_slip(Files& files) {
  add_folder(
      files, "stick_slip", *pendulum(),
      "A rod pulled by a soft spring whose end moves slowly, against friction that is larger at rest: it sticks and "
      "slips.",
      [](YamlWriter& yaml) {
        yaml.key("actuators").map();
        put_source(yaml, "swing", {40, 0.2, 40, 0});
        yaml.comment("N m/V, N m s/rad, N m/rad, rad").end();
        yaml.key("channels").map().put("time", "t").comment("s");
        yaml.key("command").short_map().key("swing").short_map().put("column", "u_1").put("unit", "V");
        yaml.end().end().end();
        yaml.key("effects").list().short_map().put("effect", "stribeck_friction").put("where", "swing");
        put_values(yaml, "parameters", {{"Fc", 2}, {"Fs", 5}, {"vs", 0.1}});
        yaml.end().comment("N m, rad/s").end();
        put_motion(yaml, {4, {}, {}, true}, "s");
      });
  files["compare/stick_slip/commands.csv"] = command_table("ramp", {1}, kCommandSamples);
}

void add_classics(Files& files) {
  add_folder(files, "double_pendulum", *double_pendulum(), "A double pendulum from high up: chaotic.",
             [](YamlWriter& yaml) {
               put_motion(yaml, {5, {{"shoulder", 2.6}, {"elbow", 1.4}}, {}}, "s, rad");
             });
  add_folder(files, "cartpole", *cartpole(),
             "A pole that falls from near upright and drags its cart: equations in closed form.", [](YamlWriter& yaml) {
               put_motion(yaml, {3, {{"pole", 0.2}}, {{"slide", 0.3}}}, "s, rad, m/s");
             });
  add_folder(files, "stiff_joint", *double_pendulum(),
             "A stiff spring with little damping at the shoulder, a free elbow: steps at the edge of stability.",
             [](YamlWriter& yaml) {
               yaml.key("actuators").map();
               put_source(yaml, "shoulder", {1, 20, 2e5, 0.5});
               yaml.comment("N m/V, N m s/rad, N m/rad, rad").end();
               put_motion(yaml, {2, {{"shoulder", 0.51}, {"elbow", 1.0}}, {}}, "s, rad");
             });
  for (const int links : {2, 10, 30, 90, 100}) {
    add_folder(files, fmt::format("long_chain_{:03}", links), *chain(links),
               fmt::format("A chain of {} links, 2 m and 4 kg in all, that falls from a bent start.", links),
               [&](YamlWriter& yaml) {
                 put_motion(yaml, {0.256, {{"joint_1", 1.0}, {"joint_2", links > 2 ? 0.3 : 0.8}}, {}}, "s, rad");
               });
  }
}

}  // namespace

void add_comparison(Files& files) {
  add_arms(files);
  add_seed_arms(files);
  add_classics(files);
  add_stick_slip(files);
}

}  // namespace lacuna::generate
