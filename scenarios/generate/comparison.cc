// scenarios/compare/: one folder a scenario, each complete in itself, to be run by `lacuna compare` and to be copied.
#include <fmt/format.h>

#include "scenarios/generate/bundle.h"

namespace lacuna::generate {
namespace {

const std::vector<int> kSeven{1, 2, 3, 4, 5, 6, 7};
constexpr int kCommandSamples = 401;  // 4 s

std::string preamble(const std::string& name, const std::string& comment) {
  return fmt::format(
      "# {}\n# Written by lacuna_generate_scenarios; change scenarios/generate/comparison.cc.\n"
      "format: lacuna-scenario/1\nname: {}\nrobot: robot.urdf\ngravity: [0.0, 0.0, -9.81]\n",
      comment, name);
}

/// A folder with its robot. `body`: the scenario after its head.
void add(Files& files, const std::string& name, const Robot& robot, const std::string& comment,
         const std::string& body) {
  files["compare/" + name + "/scenario.yaml"] = preamble(name, comment) + body;
  files["compare/" + name + "/robot.urdf"] = commented_urdf(robot, comment);
}

std::string command_channels(const std::vector<int>& joints) {
  std::string out =
      "channels:\n  time: t                      # s\n  command:                     # held between samples\n";
  for (const int joint : joints) out += fmt::format("    joint_{}: {{column: u_{}, unit: V}}\n", joint, joint);
  return out;
}

/// The seven-function arm under one excitation.
void add_arm(Files& files, const std::string& course, const std::string& comment, const std::string& extra) {
  const std::string name = "arm_" + course;
  add(files, name, *hydrolek(), comment,
      actuators(start_sources()) + extra + command_channels(kSeven) +
          "motion: {commands: commands.csv, duration: 4, position: {joint_2: 0.4, joint_3: -0.8, joint_4: 0.3, "
          "joint_5: "
          "0.3, joint_7: 0.05}}   # s, rad, m\n");
  files["compare/" + name + "/commands.csv"] = command_table(course, kSeven, kCommandSamples);
}

void add_arms(Files& files) {
  add_arm(files, "step", "The hydraulic arm: one step at every joint.", "");
  add_arm(files, "multisine", "The hydraulic arm: multisines at every joint. What is identified on every engine.",
          "identify:\n  gain:      {relative_bounds: [0.5, 2.0]}\n  damping:   {relative_bounds: [0.5, 2.0]}\n"
          "  stiffness: {relative_bounds: [0.5, 2.0]}\n");
  add_arm(files, "staircase", "The hydraulic arm: a staircase of commands at every joint.", "");
  std::vector<Source> six = start_sources();
  six.pop_back();
  add(files, "pickup", *seed_arm("pickup_arm", kTable1Masses),
      "The arm swings to its rest angles and takes hold of a load on its way.",
      actuators(six) +
          "motion: {duration: 2.4, position: {joint_2: 0.9, joint_3: -0.2, joint_5: 0.6}, pickup: {mass: 8, "
          "time: 0.6}}   # s, rad, kg\n");
  six.pop_back();
  add(files, "spinning_wrist", *skew_arm(),
      "The wrist spins with a load off its axis, principal axes askew: gyroscopic terms.",
      actuators(six) +
          "motion: {duration: 2, position: {joint_2: 0.4, joint_3: -0.8, joint_4: 0.3, joint_5: 0.3}, "
          "velocity: {joint_6: 40}}   # s, rad, rad/s\n");
  add(files, "free_swing", *seed_arm("free_arm", kTable1Masses),
      "The arm let go from a stretched pose, nothing drives or brakes it: its energy must stay.",
      "motion: {duration: 3, position: {joint_1: 0.2, joint_2: 0.6, joint_3: -0.4, joint_4: 0.3, joint_5: 0.4}}   # s, "
      "rad\n");
}

void add_classics(Files& files) {
  add(files, "double_pendulum", *double_pendulum(), "A double pendulum from high up: chaotic.",
      "motion: {duration: 5, position: {shoulder: 2.6, elbow: 1.4}}   # s, rad\n");
  add(files, "cartpole", *cartpole(),
      "A pole that falls from near upright and drags its cart: equations in closed form.",
      "motion: {duration: 3, position: {pole: 0.2}, velocity: {slide: 0.3}}   # s, rad, m/s\n");
  add(files, "stiff_joint", *double_pendulum(),
      "A stiff spring with little damping at the shoulder, a free elbow: steps at the edge of stability.",
      "actuators:\n  shoulder: {model: torque_source, gain: 1, damping: 20, stiffness: 2e5, rest: 0.5}   # N m/V, N m "
      "s/rad, N m/rad, rad\nmotion: {duration: 2, position: {shoulder: 0.51, elbow: 1.0}}   # s, rad\n");
  const std::string ramp_channels =
      "channels:\n  time: t                      # s\n  command: {swing: {column: u_1, unit: V}}\n";
  add(files, "stick_slip", *pendulum(),
      "A rod pulled by a soft spring whose end moves slowly, against friction that is larger at rest: it sticks and "
      "slips.",
      "actuators:\n  swing: {model: torque_source, gain: 40, damping: 0.2, stiffness: 40, rest: 0}   # N m/V, N m "
      "s/rad, "
      "N m/rad, rad\n" +
          ramp_channels +
          "effects:\n  - {effect: stribeck_friction, where: swing, parameters: {Fc: 2, Fs: 5, vs: 0.1}}   # N m, "
          "rad/s\nmotion: {commands: commands.csv, duration: 4}   # s\n");
  files["compare/stick_slip/commands.csv"] = command_table("ramp", {1}, kCommandSamples);
}

}  // namespace

void add_comparison(Files& files) {
  add_arms(files);
  add_classics(files);
  for (const int links : {2, 10, 30, 90, 100}) {
    add(files, fmt::format("long_chain_{:03}", links), *chain(links),
        fmt::format("A chain of {} links, 2 m and 4 kg in all, that falls from a bent start.", links),
        fmt::format("motion: {{duration: 0.256, position: {{joint_1: 1.0, joint_2: {}}}}}   # s, rad\n",
                    links > 2 ? 0.3 : 0.8));
  }
}

}  // namespace lacuna::generate
