#include "scenarios/mesh.h"

#include "scenarios/robot.h"
#include "tests/scenarios/mesh_writer.h"
#include "tests/scenarios/support.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// Coordinates are written with every digit of a float and read as floats: only a unit's factor rounds.
constexpr double kFloat = 1e-6;

/// An arm of one link that names one mesh.
std::string arm(const std::string& file, const std::string& scale = "") {
  return "<robot name='arm'><link name='base'/><link name='arm'><inertial><origin xyz='0.3 0 0'/><mass value='1'/>"
         "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial><visual><geometry><mesh filename='" +
         file + "'" + (scale.empty() ? "" : " scale='" + scale + "'") +
         "/></geometry></visual></link><joint name='turn' type='continuous'><parent link='base'/><child link='arm'/>"
         "</joint></robot>";
}

std::shared_ptr<const Robot> robot_of(const std::string& file, const std::string& scale = "") {
  return Robot::from_urdf_text(arm(file, scale), "arm.urdf");
}

const Visual& visual_of(const Robot& robot) { return robot.links()[1].visuals.at(0); }

/// Six times the volume inside: its sign says which way the triangles look.
double volume(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += static_cast<double>(mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c])));
  return sum / 6.0;
}

class Meshes : public testing::Test {
 protected:
  void SetUp() override {
    std::string reason;
    if (!meshes_available(&reason)) GTEST_SKIP() << reason;
  }
  const Mesh box_ = box_mesh({-0.1f, 0.0f, 0.2f}, {0.3f, 0.2f, 0.1f});
  TemporaryFolder folder_;
};

TEST(MeshReason, IsGivenExactlyWhereMeshesAreNotRead) {
  std::string reason;
  EXPECT_EQ(meshes_available(&reason), reason.empty());
  if (reason.empty()) return;
  std::vector<std::string> notes;
  EXPECT_EQ(visual_of(*with_meshes(*robot_of("x.stl"), {}, notes)).mesh, nullptr);
  EXPECT_EQ(notes, std::vector{reason});
  EXPECT_THROW(read_mesh("", "stl", "x.stl"), WorkError);
}

TEST_F(Meshes, AreTheSameFromEveryKindOfFile) {
  for (const auto& [format, bytes] :
       {std::pair<std::string, std::string>{"stl", text_stl(box_)}, {"stl", binary_stl(box_)}, {"obj", obj(box_)}}) {
    const Mesh read = read_mesh(bytes, format, "box." + format);
    EXPECT_EQ(read.vertices.size(), 8u) << format << ": corners at one point are one vertex";
    EXPECT_EQ(read.triangles.size(), 12u);
    EXPECT_LT((read.lower - box_.lower).norm() + (read.upper - box_.upper).norm(), kFloat) << format;
    EXPECT_NEAR(volume(read), 0.006, kFloat) << "looks outwards";
  }
}

TEST_F(Meshes, ColladaKeepsItsUnitItsPlacesAndZUpwards) {
  const Mesh read = read_mesh(collada(box_, 50.0), "dae", "box.dae");
  EXPECT_LT((read.lower - Eigen::Vector3d(0.499, 0.0, 0.002)).norm(), kFloat);
  EXPECT_LT((read.upper - Eigen::Vector3d(0.502, 0.002, 0.003)).norm(), kFloat);
  EXPECT_GT(volume(read), 0.0);
}

TEST_F(Meshes, AFaceOfManyCornersIsCutIntoTriangles) {
  const Mesh read = read_mesh("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "obj", "x.obj");
  EXPECT_EQ(read.triangles.size(), 2u);
}

TEST_F(Meshes, ScaleMayMirrorAndTheOutsideStaysOutside) {
  folder_.write("box.stl", binary_stl(box_));
  std::vector<std::string> notes;
  const auto robot = with_meshes(*robot_of("box.stl", "-2 1 1"), {folder_.path(), {}}, notes);
  ASSERT_NE(visual_of(*robot).mesh, nullptr);
  EXPECT_NEAR(volume(*visual_of(*robot).mesh), 0.012, kFloat);
  EXPECT_NEAR(visual_of(*robot).mesh->upper[0], 0.2, kFloat);
  EXPECT_THAT(notes, testing::IsEmpty());
}

TEST_F(Meshes, AreFoundBesideTheRobotByWholePathAndInPackages) {
  folder_.write("robot/visual/box.stl", binary_stl(box_));
  folder_.write("share/my_arm/meshes/box.STL", binary_stl(box_));
  const MeshFolders folders{folder_.path() / "robot", {folder_.path() / "other", folder_.path() / "share"}};
  fs::create_directories(folder_.path() / "other");
  for (const std::string& name :
       {std::string("visual/box.stl"), "file://" + (folder_.path() / "robot/visual/box.stl").string(),
        std::string("package://my_arm/meshes/box.STL"), std::string("my_arm/meshes/box.STL")}) {
    std::vector<std::string> notes;
    EXPECT_NE(visual_of(*with_meshes(*robot_of(name), folders, notes)).mesh, nullptr) << name;
  }
  std::string why;
  EXPECT_TRUE(find_mesh("package://my_arm/meshes/box.STL", {"", {folder_.path() / "share/my_arm"}}, "x", why))
      << "the package's own folder does, too";
}

TEST_F(Meshes, WhatIsNotFoundIsNotedAndLeftOut) {
  const auto note_of = [&](const std::string& name) {
    std::vector<std::string> notes;
    const auto robot = with_meshes(*robot_of(name), {folder_.path(), {}}, notes);
    EXPECT_EQ(visual_of(*robot).mesh, nullptr);
    EXPECT_EQ(notes.size(), 1u) << name;
    return notes.empty() ? "" : notes.front();
  };
  EXPECT_THAT(note_of("none.stl"), testing::AllOf(HasSubstr("link arm"), HasSubstr("none.stl"), HasSubstr("no such")));
  EXPECT_THAT(note_of("package://my_arm/box.stl"), testing::AllOf(HasSubstr("--package-path"), HasSubstr("my_arm")));
  EXPECT_THAT(note_of("http://somewhere/box.stl"), HasSubstr("file:// and package://"));
  EXPECT_THAT(note_of("box.step"), HasSubstr("STL, OBJ and DAE"));
}

TEST_F(Meshes, NoPathLeavesItsFolder) {
  folder_.write("outside.stl", binary_stl(box_));
  folder_.write("robot/here.stl", binary_stl(box_));
  folder_.write("share/my_arm/here.stl", binary_stl(box_));
  fs::create_symlink(folder_.path() / "outside.stl", folder_.path() / "robot/link.stl");
  const MeshFolders folders{folder_.path() / "robot", {folder_.path() / "share"}};
  std::string why;
  for (const std::string& name :
       {std::string("../outside.stl"), std::string("link.stl"), "file://" + (folder_.path() / "outside.stl").string(),
        (folder_.path() / "outside.stl").string(), std::string("package://my_arm/../../outside.stl"),
        std::string("package://../outside.stl"), std::string("package:///outside.stl"),
        std::string("file://robot/here.stl"), std::string("here.stl\0", 9)}) {
    EXPECT_THROW(find_mesh(name, folders, "link arm", why), InputError) << name;
  }
}

TEST_F(Meshes, WhatIsFoundAndNoMeshIsRefusedByName) {
  const auto message = [](const std::string& bytes, const std::string& format) {
    return input_error([&] { read_mesh(bytes, format, "bad." + format); });
  };
  EXPECT_THAT(message("", "stl"), HasSubstr("bad.stl: found"));
  EXPECT_THAT(message("nonsense", "stl"), HasSubstr("an STL file"));
  EXPECT_THAT(message("solid x\nendsolid x\n", "stl"), HasSubstr("expected"));
  EXPECT_THAT(message(binary_stl(box_).substr(0, 500), "stl"), HasSubstr("facets as they say"));
  EXPECT_THAT(message("v 0 0 0\n", "obj"), HasSubstr("bad.obj"));
  EXPECT_THAT(message("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj"), HasSubstr("bad.obj"));
  EXPECT_THAT(message("<html/>", "dae"), HasSubstr("<COLLADA>"));
  EXPECT_THAT(message(collada(box_, 0, "<instance_node url='#n'/>"), "dae"), HasSubstr("instance_node"));
  EXPECT_THAT(message("<!DOCTYPE x><COLLADA/>", "dae"), HasSubstr("a declaration"));
  EXPECT_THAT(message(replaced(collada(box_, 0), "count=\"24\"", "count=\"99999999\""), "dae"),
              HasSubstr("count: found"));
  EXPECT_THAT(message(replaced(collada(box_, 0), "<p>0 2", "<p>E2 2"), "dae"), HasSubstr("<p>: found \"E2\""));
  EXPECT_THAT(message(replaced(collada(box_, 0), "stride=\"3\"", "stride=\"4\""), "dae"),
              HasSubstr("32 numbers by steps of 4"));
  EXPECT_THAT(message("v 0 0 0\n", "ply"), HasSubstr("stl, obj or dae"));
  std::vector<std::string> notes;
  folder_.write("broken.stl", "nonsense");
  EXPECT_THAT(input_error([&] {
                with_meshes(*robot_of("broken.stl"), {folder_.path(), {}}, notes);
              }),
              HasSubstr("broken.stl"));
  EXPECT_THAT(input_error([&] {
                with_meshes(*robot_of("x.stl"), {folder_.path(), {folder_.path() / "none"}}, notes);
              }),
              HasSubstr("--package-path"));
}

TEST_F(Meshes, EveryLimitIsKept) {
  const auto refused = [&](const MeshLimits& limits, const std::string& part) {
    folder_.write("box.stl", binary_stl(box_));
    std::vector<std::string> notes;
    EXPECT_THAT(input_error([&] {
                  with_meshes(*robot_of("box.stl"), {folder_.path(), {}}, notes, limits);
                }),
                HasSubstr(part));
  };
  refused({.files = 0}, "more than 0 mesh files");
  refused({.file_bytes = 600}, "at most 600 bytes");
  refused({.total_bytes = 600}, "at most 600");
  refused({.triangles = 11}, "12 triangles");
  refused({.size = 0.1}, "at most 0.1 m");
  std::string polygon, corners = "f";
  for (int i = 1; i <= 1000; ++i) polygon += fmt::format("v {} {} 0\n", i, i * i), corners += fmt::format(" {}", i);
  EXPECT_THAT(input_error([&] { read_mesh(polygon + corners + "\n", "obj", "x.obj"); }), HasSubstr("1000 corners"));
}

TEST_F(Meshes, ChangeNothingButThePicture) {
  folder_.write("box.stl", binary_stl(box_));
  const auto plain = robot_of("box.stl");
  std::vector<std::string> notes;
  const auto drawn = with_meshes(*plain, {folder_.path(), {}}, notes);
  EXPECT_EQ(drawn->tool().point, plain->tool().point);
  EXPECT_EQ(drawn->tool().point, Eigen::Vector3d(0.6, 0, 0)) << "twice the centre of mass, as without visuals";
  EXPECT_EQ(to_urdf(*drawn), to_urdf(*plain));
  EXPECT_THAT(to_urdf(*plain), HasSubstr("<mesh filename=\"box.stl\"")) << "an exported robot still names its meshes";
}

}  // namespace
}  // namespace lacuna::test
