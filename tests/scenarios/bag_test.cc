#include "scenarios/bag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/scenarios/bag_writer.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::Bag;
using test::BagTopic;
using test::column;
using test::input_error;
using test::kBagStart;
using test::kMillisecond;
using test::McapWriter;
using test::TemporaryFolder;
using test::two_joint_bag;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kStampRounding = 1e-9;  // s: the grain of ROS's stamps

std::filesystem::path written(const TemporaryFolder& folder, const std::string& kind, const Bag& bag) {
  if (kind == "db3") {
    test::write_db3(folder.path() / "run.db3", bag);
    return folder.path() / "run.db3";
  }
  const std::string packing = kind == "plain chunk" ? "" : kind == "no chunks" ? "-" : kind;
  return folder.write("run.mcap", McapWriter(packing, 7).bytes(bag));
}

const std::vector<std::string> kKinds{"db3", "no chunks", "plain chunk", "lz4", "zstd"};

std::string bag_refusal(const std::filesystem::path& file) {
  return input_error([&] { load_recording(file, file.filename().string()); });
}

/// "" where it cannot be run.
std::filesystem::path written_by_python(const TemporaryFolder& folder) {
  const std::string script = std::string(LACUNA_SOURCE_DIR) + "/tests/scenarios/write_bags.py";
  const std::string line = "python3 '" + script + "' '" + folder.path().string() + "' 2>/dev/null";
  return std::system(line.c_str()) == 0 ? folder.path() : std::filesystem::path();
}

TEST(Bag, IsReadAlikeFromEveryStorage) {
  for (const std::string& kind : kKinds) {
    const TemporaryFolder folder;
    const auto data = load_recording(written(folder, kind, two_joint_bag()), "run");
    EXPECT_THAT(data->names,
                ElementsAre("time", "/joint_states/a/position", "/joint_states/a/velocity", "/joint_states/b/position",
                            "/joint_states/b/velocity", "/valves/data[0]", "/valves/data[1]"))
        << kind;
    ASSERT_EQ(data->rows(), 100u) << kind;
    for (const std::size_t i : {0u, 1u, 50u, 99u}) {
      const double x = static_cast<double>(i);
      EXPECT_NEAR(column(*data, "time")[i], 0.01 * x, kStampRounding) << kind;
      EXPECT_EQ(column(*data, "/joint_states/a/position")[i], 0.01 * x) << kind;
      EXPECT_EQ(column(*data, "/joint_states/b/velocity")[i], -1.0) << kind;
    }
    // Commands at every second sample from the tenth on, held in between.
    EXPECT_TRUE(std::isnan(column(*data, "/valves/data[0]")[9])) << kind;
    EXPECT_EQ(column(*data, "/valves/data[0]")[10], 10.0) << kind;
    EXPECT_EQ(column(*data, "/valves/data[1]")[51], -50.0) << kind;
    EXPECT_THAT(data->notes, Contains(HasSubstr("/chatter (std_msgs/msg/String)"))) << kind;
  }
}

TEST(Bag, IsReadAsAnIndependentWriterWroteIt) {
  const TemporaryFolder folder;
  if (written_by_python(folder).empty()) GTEST_SKIP() << "python3 is not installed";
  int files = 0;
  for (const char* name : {"python.db3", "python_plain.mcap", "python_zstd.mcap", "python_lz4.mcap"}) {
    if (!std::filesystem::exists(folder.path() / name)) continue;
    ++files;
    const auto data = load_recording(folder.path() / name, name);
    EXPECT_THAT(data->names, ElementsAre("time", "/joint_states/elbow/position", "/joint_states/shoulder/position"))
        << name;
    ASSERT_EQ(data->rows(), 50u) << name;
    for (std::size_t i = 0; i < 50; ++i) {
      EXPECT_NEAR(data->columns[0][i], 0.01 * static_cast<double>(i), kStampRounding) << name;
      EXPECT_EQ(column(*data, "/joint_states/shoulder/position")[i], 0.25 * static_cast<double>(i)) << name;
      EXPECT_EQ(column(*data, "/joint_states/elbow/position")[i], 1.0 / static_cast<double>(i + 1)) << name;
    }
  }
  EXPECT_GE(files, 2);
}

TEST(Bag, AsAFolderIsEveryFileThatItsMetadataLists) {
  const TemporaryFolder folder;
  Bag first = two_joint_bag(), second = first;
  second.messages.assign(first.messages.begin() + 60, first.messages.end());
  first.messages.resize(60);
  // Out of order, and below the bag's own name as older recorders write it.
  std::filesystem::create_directories(folder.path() / "run");
  test::write_db3(folder.path() / "run/run_0.db3", first);
  test::write_db3(folder.path() / "run/run_1.db3", second);
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"run/run_1.db3", "run_0.db3"}));
  const auto data = load_recording(folder.path() / "run", "run");
  EXPECT_EQ(data->rows(), 100u);
  EXPECT_EQ(column(*data, "/joint_states/a/position")[99], 0.99);
  EXPECT_EQ(recording_files(folder.path() / "run", "run").size(), 3u);
  copy_recording(folder.path() / "run", folder.path() / "copy");
  const auto copy = load_recording(folder.path() / "copy", "copy");
  EXPECT_EQ(column(*copy, "/joint_states/b/position"), column(*data, "/joint_states/b/position"));
}

TEST(Bag, OfPackedMessagesIsUnpackedAndOfPackedFilesRefusedWithTheCommand) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "run");
  test::write_db3(folder.path() / "run/run_0.db3", two_joint_bag(), true);
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"run_0.db3"}, "MESSAGE", "zstd"));
  EXPECT_EQ(column(*load_recording(folder.path() / "run", "run"), "/joint_states/a/position")[99], 0.99);
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"run_0.db3"}, "FILE", "zstd"));
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("zstd -d"));
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"run_0.db3"}, "MESSAGE", "fake"));
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("\"fake\""));
}

TEST(Bag, FolderThatLiesIsRefused) {
  const TemporaryFolder folder;
  test::write_db3(folder.path() / "outside.db3", two_joint_bag());
  std::filesystem::create_directories(folder.path() / "run");
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("without metadata.yaml"));
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {"../outside.db3"}));
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("a file in the bag's folder"));
  folder.write("run/metadata.yaml", test::bag_metadata("sqlite3", {}));
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("relative_file_paths"));
  folder.write("run/metadata.yaml", "other: 1\n");
  EXPECT_THAT(bag_refusal(folder.path() / "run"), HasSubstr("rosbag2_bagfile_information"));
}

TEST(Bag, TakesHeadersForItsClockUnlessOneIsNotFilledInOrReceiptIsAskedFor) {
  const TemporaryFolder folder;
  Bag bag = two_joint_bag(20);
  for (test::BagMessage& message : bag.messages)
    if (message.topic == 0)
      message.log_ns += message.log_ns % (20 * kMillisecond) == 2 * kMillisecond ? kMillisecond : 0;
  const auto file = folder.write("run.mcap", McapWriter("zstd").bytes(bag));
  TrackSet tracks = read_bag(file, "run.mcap", {}, false);
  ASSERT_EQ(tracks.tracks.size(), 2u);
  EXPECT_EQ(tracks.tracks[0].clock, "/joint_states/time");
  EXPECT_EQ(tracks.tracks[0].epoch_ns, kBagStart);
  EXPECT_NEAR(tracks.tracks[0].time[1], 0.010, kStampRounding);
  tracks = read_bag(file, "run.mcap", {}, true);
  EXPECT_EQ(tracks.tracks[0].epoch_ns, kBagStart + 3 * kMillisecond);
  EXPECT_NEAR(tracks.tracks[0].time[1], 0.009, kStampRounding);
  bag.messages[0].data = test::joint_state(0, {"a", "b"}, {0, 0}, {1, -1});
  tracks = read_bag(folder.write("run.mcap", McapWriter("zstd").bytes(bag)), "run.mcap", {}, false);
  EXPECT_EQ(tracks.tracks[0].epoch_ns, kBagStart + 3 * kMillisecond);
  EXPECT_THAT(tracks.notes, Contains(HasSubstr("headers without a stamp")));
}

TEST(Bag, TopicNamedByTheTimeColumnMakesTheClock) {
  const TemporaryFolder folder;
  ColumnUse use;
  use.time = "/valves/time", use.commands = {"/valves/data[0]"}, use.measured = {"/joint_states/a/position"};
  const auto data = load_recording(written(folder, "lz4", two_joint_bag()), "run", {}, use);
  EXPECT_EQ(data->names.front(), "/valves/time");
  EXPECT_EQ(data->rows(), 45u);
  EXPECT_NEAR(column(*data, "/joint_states/a/position")[3], 0.16, kStampRounding);
}

TEST(Bag, ClockIsCalledAsItIsAskedForUnlessThatIsATopicsName) {
  const TemporaryFolder folder;
  const auto file = written(folder, "db3", two_joint_bag());
  ColumnUse use;
  use.time = "t";
  EXPECT_EQ(load_recording(file, "run", {}, use)->names.front(), "t");
  use.time = "/no_such_topic/time";
  EXPECT_EQ(load_recording(file, "run", {}, use)->names.front(), "time");
}

TEST(Bag, PublishersOfOtherJointsOnOneTopicKeepTheirOwnClocks) {
  const TemporaryFolder folder;
  Bag bag = two_joint_bag();
  for (int i = 0; i < 50; ++i) {
    const std::int64_t now = kBagStart + 5 * kMillisecond + 20 * kMillisecond * i;
    bag.messages.push_back({0, now, test::joint_state(now, {"gripper"}, {double(i)})});
    // Another order of the same joints is the same publisher to us.
    if (i == 7)
      bag.messages.push_back({0, kBagStart + 2000 * kMillisecond,
                              test::joint_state(kBagStart + 1000 * kMillisecond, {"b", "a"}, {-7, 7})});
  }
  const auto data = load_recording(written(folder, "db3", bag), "run");
  ASSERT_EQ(data->rows(), 101u);
  EXPECT_EQ(column(*data, "/joint_states/a/position")[100], 7.0);
  EXPECT_EQ(column(*data, "/joint_states/b/position")[100], -7.0);
  EXPECT_NEAR(column(*data, "/joint_states/gripper/position")[1], 0.25, 1e-6);
}

TEST(Bag, TopicThatCannotBeReadIsAnErrorOnlyWhereItIsUsed) {
  const TemporaryFolder folder;
  Bag bag = two_joint_bag();
  for (test::BagMessage& message : bag.messages)
    if (message.topic == 1) message.data = test::float64_array({HUGE_VAL, 0});
  const auto file = written(folder, "zstd", bag);
  const auto data = load_recording(file, "run");
  EXPECT_EQ(data->find("/valves/data[0]"), -1);
  EXPECT_THAT(data->notes, Contains(HasSubstr("the topic is left out")));
  ColumnUse use;
  use.commands = {"/valves/data[0]"};
  EXPECT_THAT(input_error([&] { load_recording(file, "run", {}, use); }),
              HasSubstr("message 1 of /valves: found an infinite /valves/data[0]"));
}

TEST(Bag, RefusesStampsThatRunBackwardsAndTellsHowToReadThemAnyway) {
  const TemporaryFolder folder;
  Bag bag = two_joint_bag();
  bag.topics.resize(1);
  std::erase_if(bag.messages, [](const test::BagMessage& message) { return message.topic != 0; });
  bag.messages[50].data = test::joint_state(kBagStart, {"a", "b"}, {0, 0}, {0, 0});
  const auto file = written(folder, "zstd", bag);
  EXPECT_THAT(bag_refusal(file), HasSubstr("stamps: log"));
  EXPECT_EQ(read_bag(file, "run", {}, true).tracks.front().time.size(), 100u);
  bag.messages[50].data = bag.messages[49].data;
  const TrackSet twice = read_bag(written(folder, "zstd", bag), "run", {}, false);
  EXPECT_EQ(twice.tracks.front().time.size(), 99u);
  EXPECT_THAT(twice.notes, Contains(HasSubstr("1 messages of the same time")));
}

TEST(Bag, WithoutAnythingToReadSaysWhatIsThereAndWhatCouldBe) {
  const TemporaryFolder folder;
  Bag bag = two_joint_bag();
  bag.topics[0].type = "sensor_msgs/msg/Imu", bag.topics[1].encoding = "protobuf";
  const std::string message = bag_refusal(written(folder, "lz4", bag));
  EXPECT_THAT(message, HasSubstr("no topic that can be read"));
  EXPECT_THAT(message, HasSubstr("sensor_msgs/msg/JointState"));
  bag.messages.clear();
  EXPECT_THAT(bag_refusal(written(folder, "lz4", bag)), HasSubstr("sensor_msgs/msg/JointState"));
}

TEST(Bag, InSqliteMustBeClosedAndMustBeOne) {
  const TemporaryFolder folder;
  const auto file = written(folder, "db3", two_joint_bag());
  const auto before = std::filesystem::directory_iterator(folder.path());
  EXPECT_NO_THROW(load_recording(file, "run.db3"));
  EXPECT_EQ(std::distance(before, {}), 1) << "something was written beside it";
  folder.write("run.db3-wal", "messages");
  EXPECT_THAT(bag_refusal(file), HasSubstr("it was not closed"));
  EXPECT_THAT(bag_refusal(folder.write("text.db3", std::string(4096, 'x'))), HasSubstr("not a database"));
  sqlite3* db = nullptr;
  sqlite3_open((folder.path() / "view.db3").c_str(), &db);
  // Rows out of nothing, without end.
  sqlite3_exec(db,
               "CREATE TABLE topics(id, name, type, serialization_format); CREATE VIEW messages AS WITH RECURSIVE "
               "c(x) AS (VALUES(1) UNION ALL SELECT x FROM c) SELECT x AS topic_id, x AS timestamp, x AS data FROM c;",
               nullptr, nullptr, nullptr);
  sqlite3_close(db);
  EXPECT_THAT(bag_refusal(folder.path() / "view.db3"), HasSubstr("no tables topics and messages"));
}

TEST(Bag, HasNoMoreNumbersThanTheLimitAllows) {
  const TemporaryFolder folder;
  RecordingLimits limits;
  limits.bytes = 12'000;  // more than the file, less than its numbers
  const auto file = folder.write("run.mcap", McapWriter("zstd").bytes(two_joint_bag(500)));
  ASSERT_LT(std::filesystem::file_size(file), limits.bytes);
  EXPECT_THAT(input_error([&] { load_recording(file, "run.mcap", limits); }), HasSubstr("more than 1500 numbers"));
}

}  // namespace
}  // namespace lacuna
