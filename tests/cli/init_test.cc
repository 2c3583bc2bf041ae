#include <cmath>
#include <sstream>

#include "tests/cli/program.h"
#include "tests/scenarios/bag_writer.h"

namespace lacuna::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

std::vector<std::string> init(const Arm& arm, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"init", (arm.folder() / "arm.urdf").string()};
  for (const char* name : {"train.csv", "validate.csv", "test.csv"}) line.push_back((arm.folder() / name).string());
  line.insert(line.end(), {"-o", out.string()});
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST(Init, WritesAScenarioThatEveryCommandReads) {
  const Arm arm;
  const fs::path out = arm.folder() / "new";
  const Outcome outcome = lacuna(init(arm, out));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("lacuna diagnose"));
  const std::string text = text_of(out / "scenario.yaml");
  EXPECT_THAT(text, HasSubstr("degrees, scale: 0.0174532925199"));
  EXPECT_THAT(text, HasSubstr("role: validate"));
  EXPECT_TRUE(fs::exists(out / "train.csv"));  // copied: it lay outside
  const Outcome simulated = lacuna({"simulate", (out / "scenario.yaml").string()});
  EXPECT_EQ(simulated.code, 0) << simulated.err;
}

TEST(Init, LeavesRecordingsBelowItsFolderWhereTheyAre) {
  const Arm arm;
  fs::remove(arm.folder() / "scenario.yaml");
  fs::create_directories(arm.folder() / "runs");
  fs::rename(arm.folder() / "train.csv", arm.folder() / "runs" / "train.csv");
  const Outcome outcome =
      lacuna({"init", "arm.urdf", "runs/train.csv", "validate.csv", "test.csv", "-o", "."}, arm.folder());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(text_of(arm.folder() / "scenario.yaml"), HasSubstr("file: runs/train.csv, role: train"));
  EXPECT_FALSE(fs::exists(arm.folder() / "train.csv"));
}

TEST(Init, NeverOverwritesUnlessTold) {
  const Arm arm;
  const std::string before = text_of(arm.folder() / "scenario.yaml");
  expect_refused(lacuna(init(arm, arm.folder())), kBadInput, "--force");
  EXPECT_EQ(text_of(arm.folder() / "scenario.yaml"), before);
  // Nor a recording of the same name.
  const fs::path out = arm.folder() / "new";
  fs::create_directories(out);
  arm.files().write("new/train.csv", "something else\n");
  expect_refused(lacuna(init(arm, out)), kBadInput, "train.csv");
  EXPECT_EQ(text_of(out / "train.csv"), "something else\n");
  EXPECT_FALSE(fs::exists(out / "scenario.yaml"));
  EXPECT_EQ(lacuna(init(arm, out, {"--force"})).code, 0);
  EXPECT_EQ(lacuna(init(arm, arm.folder(), {"--force"})).code, 0);
  EXPECT_NE(text_of(arm.folder() / "scenario.yaml"), before);
}

TEST(Init, SaysWhatItGuessedAndWhatItAsks) {
  const Arm arm;
  const auto record = json_of(lacuna(init(arm, arm.folder() / "new", {"--json"})));
  EXPECT_EQ(record.at("format"), "lacuna-init/1");
  const std::vector<std::string> guesses = record.at("guesses"), questions = record.at("questions");
  EXPECT_THAT(guesses, Contains(HasSubstr("degrees")));
  EXPECT_THAT(questions, Contains(HasSubstr("total_mass")));
}

TEST(Init, RefusesWhatItCannotRead) {
  const Arm arm;
  const auto file = [&](const char* name) { return (arm.folder() / name).string(); };
  expect_refused(lacuna({"init"}), kBadInput, "ROBOT");
  expect_refused(lacuna({"init", file("arm.urdf")}), kBadInput, "RECORDING");
  expect_refused(lacuna({"init", file("none.urdf"), file("train.csv")}), kBadInput, "none.urdf");
  expect_refused(lacuna({"init", file("arm.urdf"), file("none.csv"), "-o", file("new")}), kBadInput, "none.csv");
  expect_refused(lacuna({"init", file("arm.urdf"), file("arm.urdf"), "-o", file("new")}), kBadInput, "arm.urdf");
  EXPECT_FALSE(fs::exists(arm.folder() / "new"));
}

/// What diagnose names, as "effect at joint".
std::vector<std::string> named_by(const std::string& scenario, const fs::path& out) {
  const auto record = json_of(lacuna({"diagnose", scenario, "-o", out.string(), "--no-engines", "--no-pictures",
                                      "--population", "20", "--generations", "5", "--json"}));
  std::vector<std::string> names;
  for (const auto& finding : record.at("findings"))
    names.push_back(finding.at("effect").get<std::string>() + " at " + finding.at("where").get<std::string>());
  return names;
}

TEST(Init, ADraftIsDiagnosedAsTheHandWrittenFile) {
  const Arm arm({"elbow.gain=25", "elbow.damping=1.4", "elbow.coulomb_friction.Fc=4"});
  const fs::path out = arm.folder() / "new";
  const Outcome outcome = lacuna(init(arm, out));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto given = named_by(arm.scenario(), arm.folder() / "given");
  ASSERT_FALSE(given.empty());
  // Where this transducer has its zero, .1 rad off the robot's own, only its user knows; untold it is a tilted base.
  const std::string drafted = text_of(out / "scenario.yaml"), scale = "scale: 0.0174532925199";
  ASSERT_THAT(drafted, HasSubstr(scale));
  arm.files().write("new/scenario.yaml", replaced(drafted, scale, scale + ", offset: 0.1"));
  EXPECT_EQ(named_by((out / "scenario.yaml").string(), arm.folder() / "drafted"), given);
}

/// The recording with its clock in milliseconds.
std::string in_milliseconds(const std::string& csv) {
  std::istringstream lines(csv);
  std::string out, line;
  std::getline(lines, line);
  out = "t_ms" + line.substr(line.find(',')) + "\n";
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    out += std::to_string(1000.0 * std::stod(line.substr(0, comma))) + line.substr(comma) + "\n";
  }
  return out;
}

TEST(Init, NeverWritesAnotherClockOverWhatIsThere) {
  const Arm arm;
  const fs::path out = arm.folder() / "ms";
  fs::create_directories(out);
  arm.files().write("ms/run.csv", in_milliseconds(text_of(arm.folder() / "train.csv")));
  const std::vector<std::string> line{"init", (arm.folder() / "arm.urdf").string(), (out / "run.csv").string(), "-o",
                                      out.string()};
  arm.files().write("ms/run_in_s.csv", "a measurement\n");
  expect_refused(lacuna(line), kBadInput, "run_in_s.csv");
  EXPECT_EQ(text_of(out / "run_in_s.csv"), "a measurement\n");
  EXPECT_FALSE(fs::exists(out / "scenario.yaml"));
  fs::remove(out / "run_in_s.csv");
  const Outcome outcome = lacuna(line);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(text_of(out / "scenario.yaml"), HasSubstr("run_in_s.csv"));
}

/// A recording of the arm as ROS would have it: states with stamps, commands by their receipt, from the fifth sample
/// on.
Bag bag_of(const fs::path& csv) {
  auto columns = columns_of(text_of(csv));
  Bag out;
  out.topics = {{"/joint_states", "sensor_msgs/msg/JointState"}, {"/elbow/command", "std_msgs/msg/Float64"}};
  for (std::size_t i = 0; i < columns["t"].size(); ++i) {
    const std::int64_t now = kBagStart + static_cast<std::int64_t>(std::llround(1e9 * columns["t"][i]));
    const double q = columns["degrees"][i] * 0.017453292519943295 + 0.1;
    out.messages.push_back({0, now + kMillisecond, joint_state(now, {"elbow"}, {q})});
    if (i >= 5) out.messages.push_back({1, now, CdrWriter().f64(columns["u"][i]).bytes()});
  }
  return out;
}

TEST(Init, TakesBagsOfEveryStorage) {
  const Arm arm;
  const fs::path from = arm.folder() / "bags", out = arm.folder() / "new";
  fs::create_directories(from / "train");
  write_db3(from / "train/train_0.db3", bag_of(arm.folder() / "train.csv"));
  arm.files().write("bags/train/metadata.yaml", bag_metadata("sqlite3", {"train_0.db3"}));
  write_db3(from / "validate.db3", bag_of(arm.folder() / "validate.csv"));
  arm.files().write("bags/test.mcap", McapWriter("zstd", 20).bytes(bag_of(arm.folder() / "test.csv")));
  const Outcome outcome = lacuna({"init", (arm.folder() / "arm.urdf").string(), (from / "train/").string(),
                                  (from / "validate.db3").string(), (from / "test.mcap").string(), "-o", out.string()});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(out / "train/train_0.db3"));
  const std::string text = text_of(out / "scenario.yaml");
  EXPECT_THAT(text, HasSubstr("elbow: \"/joint_states/elbow/position\""));
  EXPECT_THAT(text, HasSubstr("elbow: \"/elbow/command/data\""));
  EXPECT_THAT(text, HasSubstr("{file: train, role: train}"));
  EXPECT_THAT(text, HasSubstr("{file: validate.db3, role: validate}"));
  EXPECT_THAT(outcome.err, HasSubstr("only the span that all used clocks have in common"));
  const Outcome simulated = lacuna({"simulate", (out / "scenario.yaml").string()});
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  // What is simulated has the recording's clock: its first command comes .1 s after its first state.
  EXPECT_EQ(columns_of(simulated.out).at("time").front(), 0.1);
  // A scenario of bags is identified, and what is written runs again.
  const fs::path fit = arm.folder() / "fit";
  const Outcome fitted = lacuna(
      {"identify", (out / "scenario.yaml").string(), "-o", fit.string(), "--population", "20", "--generations", "5"});
  EXPECT_EQ(fitted.code, 0) << fitted.err;
}

TEST(Init, JoinsFilesOfOneMotion) {
  const Arm arm;
  const fs::path out = arm.folder() / "new";
  std::vector<std::string> line{"init", (arm.folder() / "arm.urdf").string()};
  for (const std::string name : {"train", "validate", "test"}) {
    auto columns = columns_of(text_of(arm.folder() / (name + ".csv")));
    std::ostringstream positions, commands;
    positions << "t,degrees\n", commands << "t,u\n";
    for (std::size_t i = 0; i < columns["t"].size(); ++i) {
      positions << columns["t"][i] << ',' << columns["degrees"][i] << '\n';
      if (i % 2 == 0) commands << columns["t"][i] - 0.005 << ',' << columns["u"][i] << '\n';
    }
    const auto q = arm.files().write(name + "_q.csv", positions.str()),
               u = arm.files().write(name + "_u.csv", commands.str());
    line.push_back(q.string() + "+" + u.string());
  }
  line.insert(line.end(), {"-o", out.string()});
  const Outcome outcome = lacuna(line);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(text_of(out / "scenario.yaml"), HasSubstr("{file: train_q.csv, role: train, with: [train_u.csv]}"));
  EXPECT_THAT(outcome.out, HasSubstr("do the clocks of the files joined"));
  EXPECT_TRUE(fs::exists(out / "train_u.csv"));
  const Outcome simulated = lacuna({"simulate", (out / "scenario.yaml").string()});
  EXPECT_EQ(simulated.code, 0) << simulated.err;
}

}  // namespace
}  // namespace lacuna::test
