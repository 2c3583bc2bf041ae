// Mutated inputs: whatever a file holds, loading it succeeds or throws InputError, and says so in one line.
//
// Deterministic: the same mutants every time. Meant for the sanitized build, useful in any.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/error.h"
#include "scenarios/mesh.h"
#include "scenarios/mjcf.h"
#include "scenarios/scenario.h"
#include "scenarios/yaml_reader.h"
#include "tests/fuzz/mutants.h"
#include "tests/scenarios/mesh_writer.h"
#include "draft/draft.h"

namespace lacuna {
namespace {

using test::Fuzz;
using test::kFileMutants;
using test::kMutants;
using test::kRoot;
using test::Mutator;
using test::read;
using test::survives;
using test::write;

const std::vector<std::string> kYamlTokens{":",
                                           ": ",
                                           "\n",
                                           "- ",
                                           "[",
                                           "]",
                                           "{",
                                           "}",
                                           "&a ",
                                           "*a",
                                           "!!str ",
                                           "? ",
                                           "|",
                                           ">",
                                           "#",
                                           "\"",
                                           "'",
                                           "---\n",
                                           "...\n",
                                           "%YAML 1.2\n",
                                           "~",
                                           "null",
                                           ".inf",
                                           ".nan",
                                           "1e999",
                                           "-1",
                                           "0",
                                           "joint_2",
                                           "../../x",
                                           "/dev/zero",
                                           "\t",
                                           "  ",
                                           "\\x00",
                                           std::string(1, '\0'),
                                           "\xEF\xBB\xBF",
                                           "\xff",
                                           "value",
                                           "<<: "};

TEST_F(Fuzz, ScenarioFiles) {
  const std::string valid = R"(format: lacuna-scenario/1
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
)";
  std::filesystem::copy_file(kRoot / "scenarios/hydrolek/seed_table1.urdf", folder_ / "robot.urdf");
  write(folder_ / "run.csv", "t,u_1,u_2,q_1,q_2\n0,1,2,3,4\n0.01,1,2,3,4\n0.02,1,2,3,4\n0.03,1,2,3,4\n");
  std::filesystem::copy_file(folder_ / "run.csv", folder_ / "other.csv");
  write(folder_ / "more.csv", "s,p\n0.5,1\n0.51,2\n0.55,3\n");
  write(folder_ / "scenario.yaml", valid);
  ASSERT_NO_THROW(load_scenario(folder_ / "scenario.yaml"));
  Mutator mutate(kYamlTokens, 1);
  for (int i = 0; i < kFileMutants; ++i) {
    const std::string mutant = mutate(valid);
    write(folder_ / "scenario.yaml", mutant);
    if (!survives([&] { load_scenario(folder_ / "scenario.yaml"); }, mutant)) break;
  }
}

TEST_F(Fuzz, YamlTexts) {
  const std::string valid = read(kRoot / "scenarios/hydrolek/scenario.yaml");
  Mutator mutate(kYamlTokens, 2);
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = mutate(valid);
    if (!survives([&] { parse_yaml(mutant, "s.yaml"); }, mutant)) break;
  }
}

TEST_F(Fuzz, UrdfTexts) {
  const std::vector<std::string> tokens{"<",
                                        ">",
                                        "/>",
                                        "</",
                                        "<!--",
                                        "-->",
                                        "<?",
                                        "?>",
                                        "<![CDATA[",
                                        "]]>",
                                        "&lt;",
                                        "&#0;",
                                        "'",
                                        "\"",
                                        "=",
                                        "<link name='x'/>",
                                        "<joint name='x' type='fixed'>",
                                        "type='floating'",
                                        "<mimic joint='joint_1'/>",
                                        "<mesh filename='a'/>",
                                        "<sphere/>",
                                        "<box/>",
                                        "<limit/>",
                                        "<mass value='-1'/>",
                                        "nan",
                                        "inf",
                                        "1e999",
                                        "0",
                                        "-",
                                        std::string(1, '\0'),
                                        "\xEF\xBB\xBF",
                                        "\xef",
                                        "\xff",
                                        "<a>",
                                        " name='y'",
                                        "</robot>",
                                        "<robot name='z'>",
                                        "<inertial>",
                                        "<origin rpy='1 2 3'/>",
                                        " version='9'"};
  const std::string small = read(kRoot / "scenarios/pendulum/pendulum.urdf");
  const std::string large = read(kRoot / "scenarios/hydrolek/hydrolek.urdf");
  Mutator mutate(tokens, 3);
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = mutate(i % 3 == 0 ? large : small);
    const auto work = [&] {
      // What is accepted can be written, and what is written can be read.
      const auto robot = Robot::from_urdf_text(mutant, "r.urdf");
      Robot::from_urdf_text(to_urdf(*robot), "again.urdf");
    };
    if (!survives(work, mutant)) break;
  }
}

TEST_F(Fuzz, CsvFiles) {
  const std::vector<std::string> tokens{",",
                                        ",,",
                                        "\n",
                                        "\r\n",
                                        "\r",
                                        "\"",
                                        "\"\"",
                                        "nan",
                                        "-nan",
                                        "inf",
                                        "1e999",
                                        "1e-999",
                                        "-",
                                        "+-",
                                        "0x1",
                                        "1e",
                                        " ",
                                        "\t",
                                        ";",
                                        "t",
                                        ".",
                                        "..",
                                        "e5",
                                        std::string(1, '\0'),
                                        "\xEF\xBB\xBF",
                                        "\xff",
                                        std::string(30, '9')};
  const std::string valid = "t,\"a, b\",q_1\n0,1.5,2\n0.01,-2.5e-3,nan\n0.02,,3\n0.03,4,5.123456789012345678\n";
  Mutator mutate(tokens, 4);
  RecordingLimits limits;
  limits.line_bytes = 512;
  limits.columns = 16;
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = mutate(valid);
    write(folder_ / "run.csv", mutant);
    const auto work = [&] {
      const auto data = load_recording(folder_ / "run.csv", "run.csv", limits);
      for (const auto& column : data->columns) ASSERT_EQ(column.size(), data->rows());
      write_csv(folder_ / "again.csv", *data);
    };
    if (!survives(work, mutant)) break;
  }
}

TEST_F(Fuzz, MatFiles) {
  const std::vector<std::string> tokens{std::string(4, '\0'),         std::string(4, '\xff'),
                                        std::string("\x0e\0\0\0", 4), std::string("\x0f\0\0\0", 4),
                                        std::string("\x01\0\0\0", 4), std::string("\0\0\0\x7f", 4)};
  std::vector<std::string> valid;
  for (const char* name : {"vectors.mat", "vectors_compressed.mat", "struct.mat", "struct_compressed.mat"})
    valid.push_back(read(kRoot / "tests/scenarios/data" / name));
  Mutator mutate(tokens, 5);
  for (int i = 0; i < kMutants; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    // The 128 bytes of header are text: what follows is what matters.
    const std::string mutant = origin.substr(0, 128) + mutate(origin.substr(128));
    write(folder_ / "run.mat", mutant);
    if (!survives([&] { load_recording(folder_ / "run.mat", "run.mat"); }, "mutant " + std::to_string(i))) break;
  }
}

TEST_F(Fuzz, MjcfTexts) {
  const std::vector<std::string> tokens{"<",
                                        ">",
                                        "/>",
                                        "</body>",
                                        "<body>",
                                        "<joint/>",
                                        "<geom size='.1'/>",
                                        "<inertial mass='1'/>",
                                        "<include file='/dev/zero'/>",
                                        "<default class='x'>",
                                        "class='x'",
                                        "childclass='x'",
                                        "euler='1 2 3'",
                                        "quat='0 0 0 0'",
                                        "type='mesh'",
                                        "type='capsule'",
                                        "fromto='0 0 0 0 0 0'",
                                        "nan",
                                        "1e999",
                                        "-1",
                                        "0",
                                        "<equality>",
                                        "<tendon>",
                                        "'",
                                        "\"",
                                        std::string(1, '\0'),
                                        "\xff",
                                        "1e-320",
                                        "1e308"};
  const std::string valid =
      R"(<mujoco model='m'><compiler eulerseq='zyx'/><default><joint damping='1'/><default class='x'><geom type='box' size='.1 .1 .1'/></default></default>
  <worldbody><geom type='plane' size='1 1 1'/><body name='a' euler='10 20 30' childclass='x'><joint name='j' axis='0 1 0' range='-90 90' limited='true'/><geom class='x'/>
  <body name='b' pos='1 0 0' xyaxes='1 0 0 0 1 0'><inertial pos='0 0 1' mass='2' fullinertia='.1 .1 .1 0 0 0'/><joint name='k' type='slide' pos='.1 0 0' stiffness='3'/></body>
  </body></worldbody><actuator><general joint='j' gainprm='3' biastype='affine' biasprm='1 -2 -3'/><motor joint='k' gear='2'/></actuator></mujoco>)";
  ASSERT_EQ(read_mjcf_text(valid, "m.xml").robot->dof(), 2);
  Mutator mutate(tokens, 7);
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = mutate(valid);
    const auto work = [&] {
      // What is accepted can be written as URDF, and that can be read.
      const MjcfModel model = read_mjcf_text(mutant, "m.xml");
      Robot::from_urdf_text(to_urdf(*model.robot), "again.urdf");
    };
    if (!survives(work, mutant)) break;
  }
}

TEST_F(Fuzz, MeshFiles) {
  if (std::string reason; !meshes_available(&reason)) GTEST_SKIP() << reason;
  const Mesh box = test::box_mesh({0, 0, 0}, {1, 2, 3});
  const std::vector<std::pair<std::string, std::string>> valid{{"stl", test::text_stl(box)},
                                                               {"stl", test::binary_stl(box)},
                                                               {"obj", test::obj(box)},
                                                               {"dae", test::collada(box, 5.0)}};
  const std::vector<std::string> tokens{"facet",
                                        "endfacet",
                                        "outer loop",
                                        "vertex",
                                        "endsolid",
                                        "solid",
                                        "\n",
                                        "\\\n",
                                        "f 1 2 3",
                                        "f -1 -2 -3",
                                        "f 99999999 1 2",
                                        "f 1//",
                                        "f 1/1/1 2/2/2 3/3/3",
                                        "usemtl x",
                                        "mtllib /dev/zero",
                                        "v 1",
                                        "vn 0 0 1",
                                        "l 1 2",
                                        "p 1",
                                        "curv",
                                        "nan",
                                        "inf",
                                        "1e999",
                                        "-",
                                        "<",
                                        ">",
                                        "/>",
                                        "</p>",
                                        "<p>",
                                        "count='99999999'",
                                        "stride='0'",
                                        "#v",
                                        "#p",
                                        "url='#n'",
                                        "<instance_node url='#n'/>",
                                        "<node>",
                                        "</node>",
                                        "<polylist>",
                                        "<vcount>",
                                        "offset='9'",
                                        "1.5",
                                        " .5 ",
                                        "1e3",
                                        " x ",
                                        "<!-- -->",
                                        std::string(4, '\xff'),
                                        std::string(4, '\0'),
                                        "\xff"};
  Mutator mutate(tokens, 8);
  for (int i = 0; i < kMutants; ++i) {
    const auto& [format, text] = valid[static_cast<std::size_t>(i) % valid.size()];
    const std::string mutant = mutate(text);
    const auto work = [&] {
      const Mesh mesh = read_mesh(mutant, format, "m." + format);
      ASSERT_FALSE(mesh.triangles.empty());
      for (const Eigen::Vector3f& vertex : mesh.vertices) ASSERT_TRUE(vertex.allFinite());
      for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.vertices.size());
    };
    if (!survives(work, mutant)) break;
  }
}

/// Whatever a name says, what is found lies below one of the folders.
TEST_F(Fuzz, MeshNames) {
  write(folder_ / "outside.stl", "x");
  std::filesystem::create_directories(folder_ / "robot/deep");
  std::filesystem::create_directories(folder_ / "share/arm/deep");
  write(folder_ / "robot/deep/x.stl", "x");
  write(folder_ / "share/arm/deep/x.stl", "x");
  std::filesystem::create_symlink(folder_ / "outside.stl", folder_ / "robot/link.stl");
  const MeshFolders folders{folder_ / "robot", {folder_ / "share"}};
  const std::vector<std::string> tokens{"..",
                                        "../",
                                        "/",
                                        "//",
                                        "./",
                                        "package://",
                                        "file://",
                                        "arm",
                                        "deep",
                                        "x.stl",
                                        "outside.stl",
                                        "link.stl",
                                        folder_.string(),
                                        "%2e%2e",
                                        std::string(1, '\0')};
  Mutator mutate(tokens, 9);
  int found = 0;
  for (int i = 0; i < kMutants; ++i) {
    const std::string valid[] = {"deep/x.stl", "package://arm/deep/x.stl",
                                 "file://" + (folder_ / "robot/deep/x.stl").string()};
    const std::string mutant = mutate(valid[i % 3]);
    const auto work = [&] {
      std::string why;
      const auto file = find_mesh(mutant, folders, "m", why);
      ASSERT_NE(file.has_value(), !why.empty());
      if (!file) return;
      ++found;
      const std::string whole = std::filesystem::canonical(*file).string();
      const std::string root = std::filesystem::canonical(folder_).string();
      ASSERT_TRUE(whole.starts_with(root + "/robot") || whole.starts_with(root + "/share")) << whole;
    };
    if (!survives(work, mutant)) break;
  }
  EXPECT_GT(found, 0) << "no mutant names a file: nothing was tried";
}

/// Whatever a recording is called and holds, its draft is a scenario.
TEST_F(Fuzz, Drafts) {
  const std::vector<std::string> tokens{",",      "\n",      "q_1", "u_2",  "tau_1", "i_2", "qd_1",  "t",
                                        "deg",    "joint_2", "#",   ": ",   "\"{\"", "0",   "1e308", "-1e308",
                                        "1e-320", "nan",     "",    "9999", "_ms",   "\xff"};
  std::string valid = "t,u_1,u_2,q_1,q_2,qd_1,i_2\n";
  for (int i = 0; i < 100; ++i) {
    const double t = 0.01 * i;
    for (const double value : {t, std::sin(5 * t), std::cos(3 * t), std::sin(4 * t), std::sin(3 * t), std::cos(4 * t)})
      valid += std::to_string(value) + ",";
    valid += "1\n";
  }
  const auto robot = Robot::from_urdf(kRoot / "scenarios/double_pendulum/double_pendulum.urdf");
  std::filesystem::copy_file(kRoot / "scenarios/double_pendulum/double_pendulum.urdf", folder_ / "robot.urdf");
  Mutator mutate(tokens, 6);
  for (int i = 0; i < kFileMutants / 3; ++i) {
    // The names are a small part of the file: they get mutants of their own.
    const std::size_t body = valid.find('\n');
    const std::string mutant = i % 2 == 0 ? mutate(valid) : mutate(valid.substr(0, body)) + valid.substr(body);
    write(folder_ / "run.csv", mutant);
    std::string text;
    const auto draft = [&] {
      text =
          draft_scenario({"fuzz", "robot.urdf", robot, {{"run.csv", load_recording(folder_ / "run.csv", "run.csv")}}})
              .yaml;
    };
    if (!survives(draft, mutant)) break;
    if (text.empty()) continue;
    write(folder_ / "scenario.yaml", text);
    ASSERT_NO_THROW(load_scenario(folder_ / "scenario.yaml", {.load_recordings = false}))
        << mutant.substr(0, 400) << text;
  }
}

}  // namespace
}  // namespace lacuna
