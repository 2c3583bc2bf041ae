#include "render/image.h"
#include "render/snapshot.h"
#include "scenarios/mesh.h"
#include "tests/cli/program.h"
#include "tests/scenarios/mesh_writer.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;

TEST(Render, PosesAndTimesAreChecked) {
  const Arm arm;
  const auto refused = [&](const std::vector<std::string>& options, const std::string& part) {
    std::vector<std::string> line{"render", arm.scenario(), "-o", (arm.folder() / "pictures").string()};
    line.insert(line.end(), options.begin(), options.end());
    expect_refused(lacuna(line), 2, part);
  };
  refused({"--pose", "0,1"}, "elbow");
  refused({"--pose", "nan"}, "finite");
  refused({"--pose", "inf"}, "finite");
  refused({"--pose", "0,"}, "finite");
  refused({"--time", "99"}, "from 0 to 3.98 s");
  refused({"--time", "x"}, "--time");
  refused({"--recording", "train.csv"}, "--time");
  refused({"--recording", "commands_train.csv", "--time", "1x"}, "--time");
  refused({"--width", "0"}, "pixels");
  refused({"--height", "100000"}, "pixels");
  refused({"--engine", "imaginary"}, "imaginary");
}

TEST(Render, OnePictureAnEngineAndPose) {
  const Arm arm;
  const fs::path out = arm.folder() / "pictures";
  const Outcome outcome = lacuna({"render", arm.scenario(), "--engine", "all", "--pose", "-0.4", "--time", "0.5,2.25",
                                  "--width", "160", "--height", "120", "-o", out.string(), "--json"});
  if (std::string reason; !render_available(&reason)) {
    expect_refused(outcome, 3, reason.substr(0, 20));
    return;
  }
  const auto record = json_of(outcome);
  for (const auto& engine : engine_records()) {
    for (const char* pose : {"_1.png", "_2.png", "_3.png"}) {
      const fs::path file = out / (engine.at("name").get<std::string>() + pose);
      ASSERT_EQ(fs::exists(file), engine.at("available").get<bool>()) << file;
      if (fs::exists(file)) {
        EXPECT_EQ(read_png(file).width, 160);
      }
    }
  }
  EXPECT_TRUE(fs::exists(out / "contact_sheet.png"));
  EXPECT_EQ(record.at("pictures")[0].at("q")[0], -0.4);
}

TEST(Render, MeshesOfPackagesAreDrawnAndMissingOnesAreNoted) {
  if (!render_available() || !meshes_available()) GTEST_SKIP() << "nothing to draw with";
  const Arm arm;
  const std::string urdf = text_of(arm.folder() / "arm.urdf");
  const std::string visual =
      "<visual><geometry><mesh filename='package://my_arm/box.stl' scale='.001 .001 .001'/></geometry></visual>";
  ASSERT_NE(urdf.find("<inertial>"), std::string::npos);
  arm.files().write("arm.urdf", replaced(urdf, "<inertial>", visual + "<inertial>"));
  arm.files().write("share/my_arm/box.stl", text_stl(box_mesh({0, -50, -50}, {500, 100, 400})));
  const auto picture = [&](const std::vector<std::string>& options, const std::string& name) {
    std::vector<std::string> line{"render",   arm.scenario(), "--width", "160",
                                  "--height", "120",          "-o",      (arm.folder() / name).string()};
    line.insert(line.end(), options.begin(), options.end());
    const Outcome outcome = lacuna(line);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return std::pair{outcome.err, read_png(arm.folder() / name / "featherstone_1.png")};
  };
  const auto [note, without] = picture({}, "without");
  EXPECT_THAT(note, testing::HasSubstr("--package-path"));
  const auto [silence, with] = picture({"--package-path", (arm.folder() / "share").string()}, "with");
  EXPECT_THAT(silence, testing::Not(testing::HasSubstr("not drawn")));
  EXPECT_GT(compare_images(without, with, 16).share_of_pixels_over_tolerance, 0.01);
  arm.files().write("share/my_arm/box.stl", "nonsense");
  expect_refused(lacuna({"render", arm.scenario(), "--package-path", (arm.folder() / "share").string()}), kBadInput,
                 "box.stl");
  expect_refused(lacuna({"diagnose", arm.scenario(), "--package-path", (arm.folder() / "none").string()}), kBadInput,
                 "--package-path");
}

}  // namespace
}  // namespace lacuna::test
