#include <fmt/format.h>

#include <cmath>

#include "ga/random.h"
#include "scenarios/generate/bundle.h"
#include "scenarios/scenario.h"
#include "scenarios/text.h"

namespace lacuna::generate {

std::string actuators(const std::vector<Source>& sources, std::size_t first) {
  std::string out =
      "actuators:                     # torque = gain*command - damping*velocity - stiffness*(position - rest)\n";
  for (std::size_t i = 0; i < sources.size(); ++i)
    out += fmt::format("  joint_{}: {{model: torque_source, gain: {}, damping: {}, stiffness: {}, rest: {}}}\n",
                       i + first, format_number(sources[i].gain), format_number(sources[i].damping),
                       format_number(sources[i].stiffness), format_number(sources[i].rest));
  return out;
}

const std::vector<Source>& start_sources() {
  static const std::vector<Source> sources{{120, 220, 2000, 0}, {200, 231.8, 3060, 0.4}, {70, 70, 900, -0.8},
                                           {4, 3, 40, 0.3},     {9, 8, 90, 0.3},         {1.2, 0.5, 10, 0},
                                           {20, 60, 2000, 0.05}};
  return sources;
}

namespace {

const char* const kWritten = "# Written by lacuna_generate_scenarios; change scenarios/generate/scenarios.cc.\n";

std::string head(const std::string& name, const std::string& robot) {
  return fmt::format("{}format: lacuna-scenario/1\nname: {}\nrobot: {}\ngravity: [0.0, 0.0, -9.81]\n", kWritten, name,
                     robot);
}

/// Commands, in volts.
std::string command_columns(int from, int to) {
  std::string out = "  command:                     # held between samples\n";
  for (int i = from; i <= to; ++i) out += fmt::format("    joint_{}: {{column: u_{}, unit: V}}\n", i, i);
  return out;
}

std::string columns(const char* kind, const char* prefix, int from, int to, const char* comment) {
  std::string list;
  for (int i = from; i <= to; ++i) list += fmt::format("{}joint_{}: {}_{}", i == from ? "" : ", ", i, prefix, i);
  return fmt::format("  {}: {{{}}}   # {}\n", kind, list, comment);
}

std::string recordings(const std::string& folder, const std::vector<std::pair<const char*, const char*>>& files) {
  std::string out = "recordings:                    # each starts at rest\n";
  for (const auto& [file, role] : files) out += fmt::format("  - {{file: {}/{}, role: {}}}\n", folder, file, role);
  return out;
}

/// Joint 2 moves, the others stand locked at q = 0: dry friction that no effort of the arm overcomes.
const char* const kBrakes =
    "effects:                       # the other joints are locked by brakes; N m\n"
    "  - {effect: coulomb_friction, where: joint_1, parameters: {Fc: 1e6}}\n"
    "  - {effect: coulomb_friction, where: joint_3, parameters: {Fc: 1e6}}\n"
    "  - {effect: coulomb_friction, where: joint_4, parameters: {Fc: 1e6}}\n"
    "  - {effect: coulomb_friction, where: joint_5, parameters: {Fc: 1e6}}\n"
    "  - {effect: coulomb_friction, where: joint_6, parameters: {Fc: 1e6}}\n";

std::string joint_2_actuator(const Source& source) { return actuators({source}, 2) + kBrakes; }

std::string joint_2_channels() {
  return "channels:\n  time: t                      # s\n" + command_columns(2, 2) +
         columns("position", "q", 2, 2, "rad");
}

/// The seed's preset: nine parameters, from its row "Init.", in bounds that hold both of its truths.
void add_joint_2(Files& files, const std::string& table, const Source& truth) {
  const std::string name = "joint_2_" + table;
  const Source start{100, 100, 1146, 0.4};  // 0.1 kN m/V, 100 N m s/rad, 20 N m/deg
  std::string text =
      "# The seed paper's preset: K, D, S of joint 2 and six link masses, from its row \"Init.\".\n# The truth behind "
      "the recordings is " +
      name + "/truth.yaml. Angles alone fix the nine only up to a common factor.\n";
  text += head(name, "seed_start.urdf") + "sample_period: 0.01            # s\n" + joint_2_actuator(start);
  text +=
      "identify:\n"
      "  joint_2.gain:      {bounds: [2, 500]}        # N m/V\n"
      "  joint_2.damping:   {bounds: [10, 600]}       # N m s/rad\n"
      "  joint_2.stiffness: {bounds: [300, 10000]}    # N m/rad\n";
  for (int i = 1; i <= 6; ++i) text += fmt::format("  link_{}.mass:       {{bounds: [0.1, 30]}}       # kg\n", i);
  text += joint_2_channels();
  text += recordings(name, {{"train.csv", "train"}, {"validate.csv", "validate"}, {"test.csv", "test"}});
  files["hydrolek/" + name + ".yaml"] = text;
  files["hydrolek/" + name + "/truth.yaml"] =
      "# The truth behind " + name + ".yaml: never an input to identification.\n" +
      head(name + "_truth", "../seed_" + table + ".urdf") + "sample_period: 0.01            # s\n" +
      joint_2_actuator(truth) + joint_2_channels();
}

const char* const kIdentifyAll =
    "identify:                      # start values are the ones above and in the URDF\n"
    "  gain:      {relative_bounds: [0.25, 4.0]}\n"
    "  damping:   {relative_bounds: [0.25, 4.0]}\n"
    "  stiffness: {relative_bounds: [0.25, 4.0]}\n"
    "  mass:      {relative_bounds: [0.4, 2.5]}\n";

std::string all_joints_channels() {
  return "channels:\n  time: t                      # s\n" + command_columns(1, 7) +
         columns("position", "q", 1, 7, "rad; joint_7: m");
}

void add_all_joints(Files& files) {
  std::string text = head("hydrolek", "hydrolek.urdf");
  text +=
      "sample_period: 0.01            # s\ntotal_mass: 42.6               # kg, known; individual link masses are "
      "not\n";
  text += actuators(start_sources()) + kIdentifyAll;
  text += all_joints_channels();
  text += recordings(
      "all_joints",
      {{"train_1.csv", "train"}, {"train_2.csv", "train"}, {"validate_1.csv", "validate"}, {"test_1.csv", "test"}});
  files["hydrolek/scenario.yaml"] = text;
  files["hydrolek/all_joints/truth.yaml"] = "# The truth behind scenario.yaml: never an input to identification.\n" +
                                            head("hydrolek_truth", "../hydrolek.urdf") +
                                            "sample_period: 0.01            # s\n" +
                                            actuators({{128, 208, 1570, 0},
                                                       {177, 239, 3870, 0.4},
                                                       {71, 84, 960, -0.8},
                                                       {3.0, 3.6, 46, 0.3},
                                                       {8.6, 9.2, 84, 0.3},
                                                       {1.5, 0.56, 7.8, 0},
                                                       {23, 52, 1700, 0.05}}) +
                                            all_joints_channels();
}

/// `value` times a factor drawn within 30 % of 1, to three digits.
double drawn(RandomStream& stream, double value) {
  return std::stod(fmt::format("{:.3g}", value * stream.uniform(0.7, 1.3)));
}

/// Masses of all links drawn alike, then brought to the known total; the last moving link takes the rounding.
std::vector<double> drawn_masses(RandomStream& stream, const Robot& robot) {
  std::vector<double> masses;
  double sum = 0.0;
  for (const Link& link : robot.links()) {
    masses.push_back(link.inertial.mass > 0.0 ? drawn(stream, link.inertial.mass) : 0.0);
    sum += masses.back();
  }
  const double total = robot.moving_mass();
  double rest = total;
  std::size_t last = 0;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    masses[i] = std::round(1e3 * masses[i] * total / sum) / 1e3;
    rest -= masses[i];
    if (masses[i] > 0.0) last = i;
  }
  masses[last] = std::round(1e3 * (masses[last] + rest)) / 1e3;
  return masses;
}

/// The demonstration: every parameter unknown within 30 %, and friction in the shoulder that the model leaves out.
void add_demo(Files& files) {
  constexpr std::uint64_t kSeed = 1;
  RandomStream stream(kSeed, 0, 0);
  std::vector<Source> truth;
  for (const Source& s : start_sources())
    truth.push_back({drawn(stream, s.gain), drawn(stream, s.damping), drawn(stream, s.stiffness), s.rest});
  const auto robot = hydrolek();

  files["hydrolek/demo/scenario.yaml"] =
      "# The arm with something in it that this model leaves out: `lacuna diagnose` shall find it.\n" +
      head("demo", "../hydrolek.urdf") +
      "sample_period: 0.01            # s\ntotal_mass: 42.6               # kg, known; individual link masses are "
      "not\n" +
      actuators(start_sources()) + kIdentifyAll + all_joints_channels() +
      "noise:                         # rms\n"
      "  position: {joint_1: 0.0003, joint_2: 0.0003, joint_3: 0.0003, joint_4: 0.0003, joint_5: 0.0003, joint_6: "
      "0.0003, "
      "joint_7: 0.00003}   # rad; joint_7: m\n"
      "recordings:                    # each starts at rest\n"
      "  - {file: train_1.csv, role: train}\n"
      "  - {file: train_2.csv, role: train}\n"
      "  - {file: train_3.csv, role: train}\n"
      "  - {file: validate_1.csv, role: validate}\n"
      "  - {file: test_1.csv, role: test}\n";
  files["hydrolek/demo/truth.yaml"] =
      "# The truth behind scenario.yaml: never an input to a diagnosis.\n" + head("demo_truth", "truth.urdf") +
      "sample_period: 0.01            # s\n" + actuators(truth) + all_joints_channels() +
      "effects:                       # torque -= Fc*tanh(velocity/v0); N m, rad/s\n"
      "  - {effect: coulomb_friction, where: joint_2, parameters: {Fc: 40, v0: 0.004}}\n";
  files["hydrolek/demo/truth.urdf"] = to_urdf(*robot, drawn_masses(stream, *robot));
}

void add_referee(Files& files, const std::string& name, const std::string& comment) {
  files[name + "/scenario.yaml"] = "# " + comment + "\n" + head(name, name + ".urdf");
}

}  // namespace

void add_scenarios(Files& files) {
  // 0.2 kN m/V and 53.4 N m/deg; 0.02 kN m/V and 87.4 N m/deg. The rest angle is not among the seed's parameters.
  add_joint_2(files, "table1", {200, 231.8, 3060, 0.4});
  add_joint_2(files, "table5", {20, 48, 5008, 0.4});
  add_all_joints(files);
  add_demo(files);
  add_referee(files, "pendulum",
              "Closed form: (m l^2/3 + m w^2/12 ) q'' = -m g l/2 sin q, with m 1 kg, l 1 m, rod width w 0.02 m.");
  add_referee(files, "double_pendulum", "Closed form: two rods, equations in tests/reference.");
  files["cartpole/scenario.yaml"] = "# Closed form: cart and uniform rod, equations in tests/reference.\n" +
                                    head("cartpole", "cartpole.urdf") +
                                    "actuators:\n  slide: {model: direct_effort, gain: 1, damping: 0}   # N/N, N s/m\n";
}

}  // namespace lacuna::generate
