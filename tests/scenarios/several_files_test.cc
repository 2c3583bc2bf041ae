// One recording of several files, as a scenario lists them: clocks, offsets, what is used and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenarios/recording_check.h"
#include "tests/scenarios/bag_writer.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::replaced;
using test::ScenarioFolder;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kGrain = 1e-9;  // s: the grain of ROS's stamps

/// Positions in one file, commands in another whose clock begins at 100.
const std::string kPositionFile =
    "t,q_a,q_b\n0,0.10,0.20\n0.1,0.11,0.21\n0.2,0.12,0.22\n0.3,0.13,0.23\n0.4,0.14,0.24\n";
const std::string kCommandFile = "t,u_a,u_b\n100,1,2\n100.15,3,4\n100.3,5,6\n";

std::string listing(const std::string& recording, const std::string& more = "") {
  return "format: lacuna-scenario/1\nname: two\nrobot: two.urdf\n"
         "channels:\n  time: t\n  command: {a: u_a, b: u_b}\n  position: {a: q_a, b: q_b}\n" +
         more + "recordings:\n  - " + recording + "\n";
}

class Files : public ScenarioFolder {
 public:
  explicit Files(const std::string& recording, const std::string& more = "")
      : ScenarioFolder(listing(recording, more)) {
    write("q.csv", kPositionFile);
    write("u.csv", kCommandFile);
  }
  std::string refusal() const {
    return input_error([&] { load_scenario(file); });
  }
};

const std::vector<double>& column_in(const Scenario& s, const std::string& name, std::size_t recording = 0) {
  const Recording& data = *s.recordings[recording].data;
  const int at = data.find(name);
  if (at < 0) throw std::runtime_error("no column " + name);
  return data.columns[at];
}

TEST(SeveralFiles, StandOnTheClockOfTheFirst) {
  const Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100}]}");
  const Scenario s = load_scenario(files.file);
  EXPECT_THAT(column_in(s, "t"), ElementsAre(0, 0.1, 0.2, 0.3, 0.4));
  EXPECT_THAT(column_in(s, "q_a"), ElementsAre(0.10, 0.11, 0.12, 0.13, 0.14));
  // 100.3 - 100 is a little more than .3; the rounding of a clock makes no late command.
  EXPECT_THAT(column_in(s, "u_a"), ElementsAre(1, 1, 3, 5, 5));
  EXPECT_THAT(s.notes, Contains(HasSubstr("u.csv: brought onto the clock of q.csv, held")));
}

TEST(SeveralFiles, AreUsedOverTheirCommonSpanOnly) {
  const Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -99.85}]}");
  const Scenario s = load_scenario(files.file);
  EXPECT_THAT(column_in(s, "t"), ElementsAre(0.2, 0.3, 0.4));
  EXPECT_THAT(column_in(s, "u_a"), ElementsAre(1, 3, 3));
  EXPECT_THAT(s.notes,
              Contains(HasSubstr(
                  "q.csv: only the span that all used clocks have in common is used, 0.2 to 0.4 s of 0 to 0.4 s")));
}

TEST(SeveralFiles, MeasuredValuesLieOnStraightLines) {
  const Files files("{file: u.csv, role: train, with: [{file: q.csv, clock_offset: 99.97}]}");
  const Scenario s = load_scenario(files.file);
  ASSERT_EQ(column_in(s, "t"), (std::vector<double>{100, 100.15, 100.3}));
  constexpr double kLine = 1e-9;  // rounding of times near 100 over a step of .1
  EXPECT_NEAR(column_in(s, "q_a")[0], 0.103, kLine);
  EXPECT_NEAR(column_in(s, "q_a")[1], 0.118, kLine);
  EXPECT_THAT(column_in(s, "u_a"), ElementsAre(1, 3, 5));
}

TEST(SeveralFiles, MayShareNamesWhereAPrefixSetsThemApart) {
  Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100, prefix: valve/}]}");
  files.write("scenario.yaml",
              replaced(replaced(listing("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: "
                                        "-100, prefix: valve/}]}"),
                                "a: u_a", "a: valve/q_a"),
                       "b: u_b", "b: valve/q_b"));
  files.write("u.csv", replaced(kCommandFile, "u_a,u_b", "q_a,q_b"));
  EXPECT_THAT(column_in(load_scenario(files.file), "valve/q_b"), ElementsAre(2, 2, 4, 6, 6));
  files.write("scenario.yaml", listing("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100}]}"));
  EXPECT_THAT(files.refusal(), HasSubstr("the column \"q_a\" twice"));
}

/// A bag's states and commands, and pressures in a table whose clock is that of date +%s.
TEST(SeveralFiles, OfOneEpochFindEachOther) {
  const ScenarioFolder files;
  test::write_db3(files.path() / "run.db3", test::two_joint_bag());
  files.write("p.csv", "t,p_a\n1700000000.25,1e5\n1700000000.75,2e5\n");
  files.write("scenario.yaml",
              "format: lacuna-scenario/1\nname: two\nrobot: two.urdf\nchannels:\n"
              "  command: {a: \"/valves/data[0]\", b: \"/valves/data[1]\"}\n"
              "  position: {a: /joint_states/a/position, b: /joint_states/b/position}\n"
              "  pressure_a: {a: p_a}\n"
              "recordings:\n  - {file: run.db3, role: train, with: [p.csv]}\n");
  const Scenario s = load_scenario(files.file);
  EXPECT_EQ(s.channels.time, "time");
  const auto& time = column_in(s, "time");
  ASSERT_EQ(time.size(), 51u);
  constexpr double kUnixRounding = 5e-7;  // of seconds since 1970 in a double
  EXPECT_NEAR(time.front(), 0.25, kGrain);
  EXPECT_NEAR(time.back(), 0.75, kGrain);
  EXPECT_NEAR(column_in(s, "p_a")[25], 1.5e5, 1e5 * kUnixRounding / 0.25);
  EXPECT_EQ(column_in(s, "/valves/data[0]")[0], 24.0);
  EXPECT_EQ(column_in(s, "/joint_states/b/position")[0], -0.25);
}

TEST(SeveralFiles, WhereOneKnowsNoEpochNeedAnOffset) {
  const ScenarioFolder files;
  test::write_db3(files.path() / "run.db3", test::two_joint_bag());
  files.write("u.csv", kCommandFile);
  const std::string text =
      "format: lacuna-scenario/1\nname: two\nrobot: two.urdf\nchannels:\n  command: {a: u_a, b: u_b}\n"
      "  position: {a: /joint_states/a/position, b: /joint_states/b/position}\n"
      "recordings:\n  - {file: run.db3, role: train, with: [{file: u.csv, time: t}]}\n";
  files.write("scenario.yaml", text);
  EXPECT_THAT(input_error([&] { load_scenario(files.file); }), HasSubstr("-100 would let both begin together"));
  files.write("scenario.yaml", replaced(text, "time: t}", "time: t, clock_offset: -99.5}"));
  const Scenario s = load_scenario(files.file);
  EXPECT_NEAR(column_in(s, "time").front(), 0.5, kGrain);
  EXPECT_EQ(column_in(s, "u_b")[20], 4.0);
}

TEST(SeveralFiles, TimesOfReceiptAreTakenWhereTheyAreAskedFor) {
  const ScenarioFolder files;
  test::write_db3(files.path() / "run.db3", test::two_joint_bag());
  const std::string text =
      "format: lacuna-scenario/1\nname: two\nrobot: two.urdf\nchannels:\n  command: {a: \"/valves/data[0]\"}\n"
      "  position: {a: /joint_states/a/position, b: /joint_states/b/position}\n"
      "recordings:\n  - {file: run.db3, role: train, stamps: header}\n";
  files.write("scenario.yaml", text);
  EXPECT_EQ(column_in(load_scenario(files.file), "/valves/data[0]").size(), 90u);
  // States are received 2 ms after they were stamped: the command of that instant is 2 ms old, and the same one.
  files.write("scenario.yaml", replaced(text, "stamps: header", "stamps: log"));
  const Scenario log = load_scenario(files.file);
  EXPECT_EQ(column_in(log, "/valves/data[0]").size(), 90u);
  EXPECT_TRUE(log.recordings[0].log_times);
  files.write("scenario.yaml", replaced(text, "stamps: header", "stamps: mine"));
  EXPECT_THAT(input_error([&] { load_scenario(files.file); }), HasSubstr("found \"mine\", expected header or log"));
}

TEST(SeveralFiles, AreSavedWithTheScenarioAndLoadToTheSameValues) {
  const Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100, time: t}]}");
  const Scenario original = load_scenario(files.file);
  const test::TemporaryFolder elsewhere;
  for (const auto& target : {files.path() / "again.yaml", elsewhere.path() / "out/s.yaml"}) {
    save_scenario(original, target);
    const Scenario again = load_scenario(target);
    EXPECT_EQ(again.recordings[0].data->columns, original.recordings[0].data->columns);
    EXPECT_EQ(again.recordings[0].with[0].clock_offset, -100.0);
  }
}

TEST(SeveralFiles, BagFoldersAreSavedAsFolders) {
  const ScenarioFolder files;
  std::filesystem::create_directories(files.path() / "run");
  test::write_db3(files.path() / "run/run_0.db3", test::two_joint_bag());
  files.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"run_0.db3"}));
  files.write("scenario.yaml",
              "format: lacuna-scenario/1\nname: two\nrobot: two.urdf\nchannels:\n  position: {a: "
              "/joint_states/a/position}\nrecordings:\n  - {file: run, role: train}\n");
  const Scenario original = load_scenario(files.file);
  const test::TemporaryFolder elsewhere;
  save_scenario(original, elsewhere.path() / "s.yaml");
  const Scenario again = load_scenario(elsewhere.path() / "s.yaml");
  EXPECT_EQ(column_in(again, "/joint_states/a/position"), column_in(original, "/joint_states/a/position"));
}

TEST(SeveralFiles, RefuseWhatIsUnclear) {
  const auto refusal = [](const std::string& recording) { return Files(recording).refusal(); };
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [u.csv]}"),
              HasSubstr("u.csv from 100 to 100.3 s and q.csv from 0 to 0.4 s"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [none.csv]}"), HasSubstr("no file \"none.csv\""));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [../u.csv]}"), HasSubstr("a file in the scenario's folder"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: u.csv}"), HasSubstr("recordings[0].with"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [{file: u.csv, offset: 3}]}"), HasSubstr("offset"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: .nan}]}"),
              HasSubstr("clock_offset"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, with: [{file: u.csv, time: s}]}"),
              HasSubstr("u.csv: found no column \"s\""));
  EXPECT_THAT(refusal("{file: q.csv, role: train, stamps: log}"), HasSubstr("a bag"));
  EXPECT_THAT(refusal("{file: q.csv, role: train, to: 0.2, with: [{file: u.csv, clock_offset: -100}]}\n"
                      "  - {file: q.csv, role: test, from: 0.2, with: [{file: u.csv, clock_offset: -99}]}"),
              HasSubstr("it is one recording"));
}

TEST(SeveralFiles, ThatRunBackwardsAreNamed) {
  const Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100}]}");
  files.write("u.csv", "t,u_a,u_b\n100,1,2\n100.2,3,4\n100.1,5,6\n");
  EXPECT_THAT(files.refusal(), HasSubstr("u.csv: t, value 3: found 100.1, expected time that increases"));
}

TEST(SeveralFiles, LastLinesThatALoggerCutAreNoSamples) {
  const Files files("{file: q.csv, role: train, with: [{file: u.csv, clock_offset: -100}]}");
  files.write("u.csv", "t,u_a,u_b\n100,1,2\n100.1,3,4\n100.2,5");
  EXPECT_THAT(column_in(load_scenario(files.file), "u_a"), ElementsAre(1, 3, 3, 3, 3));
}

}  // namespace
}  // namespace lacuna
