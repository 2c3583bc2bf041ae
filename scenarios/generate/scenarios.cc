#include <fmt/format.h>

#include <cmath>

#include "ga/random.h"
#include "scenarios/generate/bundle.h"
#include "scenarios/scenario.h"

namespace lacuna::generate {

void put_source(YamlWriter& yaml, const std::string& joint, const Source& source) {
  yaml.key(joint).short_map().put("model", "torque_source").put("gain", source.gain).put("damping", source.damping);
  yaml.put("stiffness", source.stiffness).put("rest", source.rest).end();
}

void put_actuators(YamlWriter& yaml, const std::vector<Source>& sources, std::size_t first) {
  yaml.key("actuators").comment("torque = gain*command - damping*velocity - stiffness*(position - rest)").map();
  for (std::size_t i = 0; i < sources.size(); ++i) put_source(yaml, fmt::format("joint_{}", i + first), sources[i]);
  yaml.end();
}

void put_commands(YamlWriter& yaml, const std::vector<int>& joints) {
  yaml.key("command").comment("held between samples").map();
  for (const int i : joints)
    yaml.key(fmt::format("joint_{}", i)).short_map().put("column", fmt::format("u_{}", i)).put("unit", "V").end();
  yaml.end();
}

void put_factors(YamlWriter& yaml, const char* parameter, double least, double most) {
  yaml.key(parameter).short_map().put("relative_bounds", {least, most}).end();
}

const std::vector<Source>& start_sources() {
  static const std::vector<Source> sources{{120, 220, 2000, 0}, {200, 231.8, 3060, 0.4}, {70, 70, 900, -0.8},
                                           {4, 3, 40, 0.3},     {9, 8, 90, 0.3},         {1.2, 0.5, 10, 0},
                                           {20, 60, 2000, 0.05}};
  return sources;
}

namespace {

const std::vector<int> kAllJoints{1, 2, 3, 4, 5, 6, 7};
constexpr double kSamplePeriod = 0.01;  // s

}  // namespace

void put_head(YamlWriter& yaml, const std::string& remark, const std::string& name, const std::string& robot) {
  if (!remark.empty()) yaml.remark(remark);
  yaml.remark("Written by lacuna_generate_scenarios; change scenarios/generate/scenarios.cc.");
  yaml.map().put("format", "lacuna-scenario/1").put("name", name).put("robot", robot);
  yaml.put("gravity", {0.0, 0.0, -9.81});
}

void put_sampled_head(YamlWriter& yaml, const std::string& remark, const std::string& name, const std::string& robot) {
  put_head(yaml, remark, name, robot);
  yaml.put("sample_period", kSamplePeriod).comment("s");
}

void put_recordings(YamlWriter& yaml, const std::string& folder,
                    const std::vector<std::pair<const char*, const char*>>& files) {
  yaml.key("recordings").comment("each starts at rest").list();
  for (const auto& [file, role] : files) yaml.short_map().put("file", folder + file).put("role", role).end();
  yaml.end();
}

void put_brakes(YamlWriter& yaml, const std::vector<const char*>& joints, const std::function<void()>& besides) {
  yaml.key("effects").comment("the other joints are locked by brakes; N m").list();
  if (besides) besides();
  for (const char* joint : joints) {
    yaml.short_map().put("effect", "coulomb_friction").put("where", joint);
    yaml.key("parameters").short_map().put("Fc", 1e6).end().end();
  }
  yaml.end();
}

double drawn(RandomStream& stream, double value) {
  return std::stod(fmt::format("{:.3g}", value * stream.uniform(0.7, 1.3)));
}

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

namespace {

/// Commands in volts and positions of the joints.
void put_channels(YamlWriter& yaml, const std::vector<int>& joints, const char* units) {
  yaml.key("channels").map().put("time", "t").comment("s");
  put_commands(yaml, joints);
  yaml.key("position").short_map();
  for (const int i : joints) yaml.put(fmt::format("joint_{}", i), fmt::format("q_{}", i));
  yaml.end().comment(units).end();
}

void put_joint_2(YamlWriter& yaml, const Source& source) {
  put_actuators(yaml, {source}, 2);
  put_brakes(yaml, {"joint_1", "joint_3", "joint_4", "joint_5", "joint_6"});
}

void put_joint_2_bounds(YamlWriter& yaml) {
  const auto put = [&](const std::string& parameter, double least, double most, const char* unit) {
    yaml.key(parameter).short_map().put("bounds", {least, most}).end().comment(unit);
  };
  yaml.key("identify").map();
  put("joint_2.gain", 2, 500, "N m/V");
  put("joint_2.damping", 10, 600, "N m s/rad");
  put("joint_2.stiffness", 300, 10000, "N m/rad");
  for (int i = 1; i <= 6; ++i) put(fmt::format("link_{}.mass", i), 0.1, 30, "kg");
  yaml.end();
}

/// The seed's preset: nine parameters, from its row "Init.", in bounds that hold both of its truths.
void add_joint_2(Files& files, const std::string& table, const Source& truth) {
  const std::string name = "joint_2_" + table;
  const Source start{100, 100, 1146, 0.4};  // 0.1 kN m/V, 100 N m s/rad, 20 N m/deg
  YamlWriter yaml(kCommentColumn);
  put_sampled_head(yaml,
                   "The seed paper's preset: K, D, S of joint 2 and six link masses, from its row \"Init.\".\n"
                   "The truth behind the recordings is " +
                       name + "/truth.yaml. Angles alone fix the nine only up to a common factor.",
                   name, "seed_start.urdf");
  put_joint_2(yaml, start);
  put_joint_2_bounds(yaml);
  put_channels(yaml, {2}, "rad");
  put_recordings(yaml, name + "/", {{"train.csv", "train"}, {"validate.csv", "validate"}, {"test.csv", "test"}});
  add(files, "hydrolek/" + name + ".yaml", yaml);

  YamlWriter hidden(kCommentColumn);
  put_sampled_head(hidden, "The truth behind " + name + ".yaml: never an input to identification.", name + "_truth",
                   "../seed_" + table + ".urdf");
  put_joint_2(hidden, truth);
  put_channels(hidden, {2}, "rad");
  add(files, "hydrolek/" + name + "/truth.yaml", hidden);
}

/// What the arm's scenarios know before their recordings.
void put_arm(YamlWriter& yaml) {
  yaml.put("total_mass", 42.6).comment("kg, known; individual link masses are not");
  put_actuators(yaml, start_sources());
  yaml.key("identify").comment("start values are the ones above and in the URDF").map();
  for (const char* parameter : {"gain", "damping", "stiffness"}) put_factors(yaml, parameter, 0.25, 4.0);
  put_factors(yaml, "mass", 0.4, 2.5);
  yaml.end();
  put_channels(yaml, kAllJoints, "rad; joint_7: m");
}

void add_all_joints(Files& files) {
  YamlWriter yaml(kCommentColumn);
  put_sampled_head(yaml, "", "hydrolek", "hydrolek.urdf");
  put_arm(yaml);
  put_recordings(
      yaml, "all_joints/",
      {{"train_1.csv", "train"}, {"train_2.csv", "train"}, {"validate_1.csv", "validate"}, {"test_1.csv", "test"}});
  add(files, "hydrolek/scenario.yaml", yaml);

  YamlWriter truth(kCommentColumn);
  put_sampled_head(truth, "The truth behind scenario.yaml: never an input to identification.", "hydrolek_truth",
                   "../hydrolek.urdf");
  put_actuators(truth, {{128, 208, 1570, 0},
                        {177, 239, 3870, 0.4},
                        {71, 84, 960, -0.8},
                        {3.0, 3.6, 46, 0.3},
                        {8.6, 9.2, 84, 0.3},
                        {1.5, 0.56, 7.8, 0},
                        {23, 52, 1700, 0.05}});
  put_channels(truth, kAllJoints, "rad; joint_7: m");
  add(files, "hydrolek/all_joints/truth.yaml", truth);
}

void put_demo_noise(YamlWriter& yaml) {
  yaml.key("noise").comment("rms").map().key("position").short_map();
  for (const int i : kAllJoints) yaml.put(fmt::format("joint_{}", i), i < 7 ? 3e-4 : 3e-5);
  yaml.end().comment("rad; joint_7: m").end();
}

/// The truth's friction, which the model leaves out.
void put_demo_friction(YamlWriter& yaml) {
  yaml.key("effects").comment("torque -= Fc*tanh(velocity/v0); N m, rad/s").list();
  yaml.short_map().put("effect", "coulomb_friction").put("where", "joint_2");
  yaml.key("parameters").short_map().put("Fc", 40.0).put("v0", 0.004).end().end().end();
}

/// The demonstration: every parameter unknown within 30 %, and friction in the shoulder that the model leaves out.
void add_demo(Files& files) {
  constexpr std::uint64_t kSeed = 1;
  RandomStream stream(kSeed, 0, 0);
  std::vector<Source> sources;
  for (const Source& s : start_sources())
    sources.push_back({drawn(stream, s.gain), drawn(stream, s.damping), drawn(stream, s.stiffness), s.rest});
  const auto robot = hydrolek();

  YamlWriter yaml(kCommentColumn);
  put_sampled_head(yaml, "The arm with something in it that this model leaves out: `lacuna diagnose` shall find it.",
                   "demo", "../hydrolek.urdf");
  put_arm(yaml);
  put_demo_noise(yaml);
  put_recordings(yaml, "",
                 {{"train_1.csv", "train"},
                  {"train_2.csv", "train"},
                  {"train_3.csv", "train"},
                  {"validate_1.csv", "validate"},
                  {"test_1.csv", "test"}});
  add(files, "hydrolek/demo/scenario.yaml", yaml);

  YamlWriter truth(kCommentColumn);
  put_sampled_head(truth, "The truth behind scenario.yaml: never an input to a diagnosis.", "demo_truth", "truth.urdf");
  put_actuators(truth, sources);
  put_channels(truth, kAllJoints, "rad; joint_7: m");
  put_demo_friction(truth);
  add(files, "hydrolek/demo/truth.yaml", truth);
  files["hydrolek/demo/truth.urdf"] = to_urdf(*robot, drawn_masses(stream, *robot));
}

void add_referee(Files& files, const std::string& name, const std::string& comment) {
  YamlWriter yaml;
  put_head(yaml, comment, name, name + ".urdf");
  add(files, name + "/scenario.yaml", yaml);
}

void add_cartpole(Files& files) {
  YamlWriter yaml;
  put_head(yaml, "Closed form: cart and uniform rod, equations in tests/reference.", "cartpole", "cartpole.urdf");
  yaml.key("actuators").map().key("slide");
  yaml.short_map().put("model", "direct_effort").put("gain", 1.0).put("damping", 0.0).end().comment("N/N, N s/m").end();
  add(files, "cartpole/scenario.yaml", yaml);
}

}  // namespace

void add(Files& files, const std::string& name, YamlWriter& yaml) { files[name] = yaml.end().str() + "\n"; }

void add_scenarios(Files& files) {
  // 0.2 kN m/V and 53.4 N m/deg; 0.02 kN m/V and 87.4 N m/deg. The rest angle is not among the seed's parameters.
  add_joint_2(files, "table1", {200, 231.8, 3060, 0.4});
  add_joint_2(files, "table5", {20, 48, 5008, 0.4});
  add_all_joints(files);
  add_demo(files);
  add_hydraulic(files);
  add_referee(files, "pendulum",
              "Closed form: (m l^2/3 + m w^2/12 ) q'' = -m g l/2 sin q, with m 1 kg, l 1 m, rod width w 0.02 m.");
  add_referee(files, "double_pendulum", "Closed form: two rods, equations in tests/reference.");
  add_cartpole(files);
}

}  // namespace lacuna::generate
