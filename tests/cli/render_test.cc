#include "render/image.h"
#include "render/snapshot.h"
#include "tests/cli/program.h"

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

}  // namespace
}  // namespace lacuna::test
