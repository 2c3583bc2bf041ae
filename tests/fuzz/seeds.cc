#include "tests/fuzz/seeds.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "tests/fuzz/loaders.h"
#include "tests/scenarios/bag_writer.h"
#include "tests/scenarios/hdf5_mat_writer.h"
#include "tests/scenarios/mesh_writer.h"

namespace lacuna::test {
namespace fs = std::filesystem;

namespace {

std::vector<std::string> files(const std::vector<const char*>& names) {
  std::vector<std::string> out;
  for (const char* name : names) out.push_back(read(kRoot / name));
  return out;
}

/// What `make` writes to the file that it is given.
template <typename Make>
std::string written(const char* name, const Make& make) {
  const fs::path file = fs::temp_directory_path() / (std::to_string(::getpid()) + name);
  fs::remove(file);
  make(file);
  std::string out = read(file);
  fs::remove(file);
  return out;
}

/// A few messages of every kind.
Bag small_bag() {
  Bag out = two_joint_bag(14);
  out.topics.push_back({"/pull", "geometry_msgs/msg/WrenchStamped"});
  out.topics.push_back({"/all", "control_msgs/msg/DynamicJointState"});
  for (int i = 0; i < 3; ++i) {
    const std::int64_t now = kBagStart + 50 * kMillisecond * i;
    out.messages.push_back({3, now, CdrWriter().header(now).f64(1).f64(2).f64(3).f64(4).f64(5).f64(6).bytes()});
    out.messages.push_back({4, now, CdrWriter().header(now).texts({"a"}).u32(1).texts({"p"}).numbers({1e5}).bytes()});
  }
  return out;
}

void write_mat73(const fs::path& file, bool packed) {
  Hdf5MatWriter writer(file);
  writer.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 0.1, 0.2}, packed);
  if (packed) writer.vector<float>("q_1", MAT_C_SINGLE, MAT_T_SINGLE, {1, 2, 3}, packed);
  if (!packed) writer.structure("log", {{"q_1", {1, 2, 3}}, {"u_1", {4, 5, 6}}});
}

}  // namespace

std::vector<std::string> seeds_of_scenario() {
  return {R"(format: lacuna-scenario/1
name: fuzz
robot: robot.urdf
gravity: [0, 0, -9.81]
sample_period: 0.01
actuators:
  joint_1: {model: torque_source, gain: 10, damping: 2}
  joint_2: {model: torque_source, gain: 5, damping: 1}
identify:
  gain: {relative_bounds: [0.5, 2.0]}
  joint_2.damping: [1, 4]
channels:
  time: t
  command: {joint_1: u_1, joint_2: {column: u_2, scale: 2, offset: -1}}
  position: {joint_1: q_1, joint_2: q_2}
noise: {position: 0.001}
recordings:
  - {file: run.csv, role: train, from: 0.0, to: 0.02}
  - {file: run.csv, role: test}
  - {file: other.csv, role: validate, stamps: header, with: [{file: more.csv, clock_offset: -0.5, time: s, prefix: x/}]}
effects:
  - {effect: payload, where: arm, parameters: {m: {value: 3.5, ci95: [3, 4]}}, recordings: [run.csv]}
  - {effect: learned_effort, where: joint_1, over: [q], knots: [0, 1, 2, 3], values: [0, 1, 0, -1]}
  - {effect: learned_effort, where: joint_2, over: [joint_1.q, v], knots: [[0, 1, 2, 3], [-0.1, 0.1]], values: [[0, 1], [2, 3], [4, 5], [6, 7]]}
  - {effect: learned_command, where: joint_2, over: [u], knots: [-3, -1, 1, 3], values: [0, 0.1, 0, 0], period: 8}
  - {effect: learned_effort, where: joint_2, events: [{recording: run.csv, from: 0.01, to: 0.02, value: 3, rise: 0.002}]}
  - {effect: learned_command, where: joint_1, events: [{recording: run.csv, from: 0.01, to: 0.03, value: 0}]}
prediction: {horizon: 0.2}
)",
          read(kRoot / "scenarios/pendulum/scenario.yaml")};
}

std::vector<std::string> seeds_of_urdf() {
  return files(
      {"scenarios/pendulum/pendulum.urdf", "scenarios/cartpole/cartpole.urdf", "scenarios/hydrolek/hydrolek.urdf"});
}

std::vector<std::string> seeds_of_mjcf() {
  return {
      R"(<mujoco model='m'><compiler eulerseq='zyx'/><default><joint damping='1'/><default class='x'><geom type='box' size='.1 .1 .1'/></default></default>
  <worldbody><geom type='plane' size='1 1 1'/><body name='a' euler='10 20 30' childclass='x'><joint name='j' axis='0 1 0' range='-90 90' limited='true'/><geom class='x'/>
  <body name='b' pos='1 0 0' xyaxes='1 0 0 0 1 0'><inertial pos='0 0 1' mass='2' fullinertia='.1 .1 .1 0 0 0'/><joint name='k' type='slide' pos='.1 0 0' stiffness='3'/></body>
  </body></worldbody><actuator><general joint='j' gainprm='3' biastype='affine' biasprm='1 -2 -3'/><motor joint='k' gear='2'/></actuator></mujoco>)"};
}

std::vector<std::string> seeds_of_csv() {
  return {"t,\"a, b\",q_1\n0,1.5,2\n0.01,-2.5e-3,nan\n0.02,,3\n0.03,4,5.123456789012345678\n"};
}

std::vector<std::string> seeds_of_mat() {
  return files({"tests/scenarios/data/vectors.mat", "tests/scenarios/data/vectors_compressed.mat",
                "tests/scenarios/data/struct.mat", "tests/scenarios/data/struct_compressed.mat"});
}

std::vector<std::string> seeds_of_mat73() {
  std::vector<std::string> out;
  for (const bool packed : {false, true})
    out.push_back(written("seed.mat", [&](const fs::path& file) { write_mat73(file, packed); }));
  return out;
}

std::vector<std::string> seeds_of_db3() {
  std::vector<std::string> out;
  for (const Bag& bag : {small_bag(), two_joint_bag(150)})
    out.push_back(written("seed.db3", [&](const fs::path& file) { write_db3(file, bag); }));
  return out;
}

/// Without checksums but for one, so that mutants get past them.
std::vector<std::string> seeds_of_mcap() {
  const Bag bag = small_bag();
  return {McapWriter("-", 0, false).bytes(bag), McapWriter("", 9, false).bytes(bag),
          McapWriter("zstd", 9, false).bytes(bag), McapWriter("lz4", 9, false).bytes(bag),
          McapWriter("zstd").bytes(bag)};
}

std::vector<std::string> seeds_of_bag_metadata() { return {bag_metadata("sqlite3", {"run_0.db3"})}; }

const std::vector<std::string>& message_types() {
  static const std::vector<std::string> types{"sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray",
                                              "trajectory_msgs/msg/JointTrajectory",
                                              "control_msgs/msg/DynamicJointState", "control_msgs/msg/MultiDOFCommand"};
  return types;
}

std::vector<std::string> seeds_of_message() {
  CdrWriter trajectory;
  trajectory.header(5).texts({"a", "b"}).u32(1).numbers({1, 2}).numbers({}).numbers({}).numbers({3, 4}).i32(0).u32(0);
  const auto of_type = [](char type, const std::string& bytes) { return std::string(1, type) + bytes; };
  return {of_type(0, joint_state(5, {"a", "b"}, {1, 2}, {3, 4}, {5, 6})),
          of_type(0, joint_state(5, {"a", "b"}, {1, 2}, {}, {}, true)),
          of_type(1, float64_array({1, 2, 3})),
          of_type(2, trajectory.bytes()),
          of_type(3, CdrWriter().header(1).texts({"a"}).u32(1).texts({"p", "q"}).numbers({1, 2}).bytes()),
          of_type(4, CdrWriter().texts({"x"}).numbers({4}).numbers({}).bytes())};
}

std::vector<std::string> seeds_of_mesh() {
  const Mesh box = box_mesh({0, 0, 0}, {1, 2, 3});
  return {"s" + text_stl(box), "s" + binary_stl(box), "o" + obj(box), "d" + collada(box, 5.0)};
}

std::vector<std::string> seeds_of_draft() {
  std::string out = "t,u_1,u_2,q_1,q_2,qd_1,i_2\n";
  for (int i = 0; i < 100; ++i) {
    const double t = 0.01 * i;
    for (const double value : {t, std::sin(5 * t), std::cos(3 * t), std::sin(4 * t), std::sin(3 * t), std::cos(4 * t)})
      out += std::to_string(value) + ",";
    out += "1\n";
  }
  return {out};
}

}  // namespace lacuna::test
