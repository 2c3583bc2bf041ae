// Mutated bags and MATLAB 7.3 files: whatever a folder, a database, a file in MCAP or a message holds, loading it
// succeeds or throws InputError.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/cdr.h"
#include "scenarios/recording.h"
#include "scenarios/ros_message.h"
#include "tests/fuzz/mutants.h"
#include "tests/scenarios/bag_writer.h"
#include "tests/scenarios/hdf5_mat_writer.h"

namespace lacuna {
namespace {

using test::Bag;
using test::CdrWriter;
using test::Fuzz;
using test::kFileMutants;
using test::kMutants;
using test::McapWriter;
using test::Mutator;
using test::read;
using test::survives;
using test::write;

const std::vector<std::string> kNumbers{std::string(4, '\0'),
                                        std::string(8, '\xff'),
                                        std::string("\x01\0\0\0", 4),
                                        std::string("\xff\xff\xff\x7f", 4),
                                        std::string("\x03\0\0\0\0\0\0\0\0", 9),
                                        std::string("\x05\xff\xff\0\0\0\0\0\0", 9),
                                        "zstd",
                                        "lz4",
                                        std::string("\x28\xb5\x2f\xfd", 4),
                                        std::string("\x04\x22\x4d\x18", 4)};

/// A few messages of every kind.
Bag small_bag() {
  Bag out = test::two_joint_bag(14);
  out.topics.push_back({"/pull", "geometry_msgs/msg/WrenchStamped"});
  out.topics.push_back({"/all", "control_msgs/msg/DynamicJointState"});
  for (int i = 0; i < 3; ++i) {
    const std::int64_t now = test::kBagStart + 50 * test::kMillisecond * i;
    out.messages.push_back({3, now, CdrWriter().header(now).f64(1).f64(2).f64(3).f64(4).f64(5).f64(6).bytes()});
    out.messages.push_back({4, now, CdrWriter().header(now).texts({"a"}).u32(1).texts({"p"}).numbers({1e5}).bytes()});
  }
  return out;
}

void load(const std::filesystem::path& path) {
  const auto data = load_recording(path, path.filename().string());
  for (const auto& column : data->columns) ASSERT_EQ(column.size(), data->rows());
}

TEST_F(Fuzz, McapFiles) {
  const Bag bag = small_bag();
  // Without checksums, so that mutants get past them.
  const std::vector<std::string> valid{McapWriter("-", 0, false).bytes(bag), McapWriter("", 9, false).bytes(bag),
                                       McapWriter("zstd", 9, false).bytes(bag), McapWriter("lz4", 9, false).bytes(bag),
                                       McapWriter("zstd").bytes(bag)};
  Mutator mutate(kNumbers, 11);
  for (int i = 0; i < kMutants; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    write(folder_ / "run.mcap", origin.substr(0, 8) + mutate(origin.substr(8)));
    if (!survives([&] { load(folder_ / "run.mcap"); }, "mutant " + std::to_string(i))) break;
  }
}

TEST_F(Fuzz, BagDatabases) {
  std::vector<std::string> valid;
  for (const bool large : {false, true}) {
    test::write_db3(folder_ / "run.db3", large ? test::two_joint_bag(150) : small_bag());
    valid.push_back(read(folder_ / "run.db3"));
  }
  Mutator mutate(kNumbers, 12);
  for (int i = 0; i < kFileMutants; ++i) {
    // Most of a database's structure stands at the beginning of its pages.
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    const std::size_t page = 4096 * (static_cast<std::size_t>(i / 2) % (origin.size() / 4096));
    const std::string mutant =
        i % 3 == 0 ? mutate(origin)
                   : origin.substr(0, page) + mutate(origin.substr(page, 64)) + origin.substr(page + 64);
    write(folder_ / "run.db3", mutant);
    if (!survives([&] { load(folder_ / "run.db3"); }, "mutant " + std::to_string(i))) break;
  }
}

TEST_F(Fuzz, BagMetadata) {
  const std::vector<std::string> tokens{
      ": ",        "\n", "- ", "[",    "]",       "{",    "}",  "~",  "../", "/dev/zero", "metadata.yaml",
      "run_0.db3", ".",  "..", "FILE", "MESSAGE", "zstd", "  ", "\"", "\xff"};
  std::filesystem::create_directories(folder_ / "run");
  test::write_db3(folder_ / "run/run_0.db3", small_bag());
  const std::string valid = test::bag_metadata("sqlite3", {"run_0.db3"});
  Mutator mutate(tokens, 13);
  for (int i = 0; i < kFileMutants / 3; ++i) {
    const std::string mutant = mutate(valid);
    write(folder_ / "run/metadata.yaml", mutant);
    if (!survives([&] { load(folder_ / "run"); }, mutant)) break;
  }
}

/// Version 7.3: read by a process of its own, which may end as it likes.
TEST_F(Fuzz, Hdf5MatFiles) {
  const std::vector<std::string> tokens{std::string(8, '\0'),         std::string(8, '\xff'), "TREE", "SNOD", "HEAP",
                                        std::string("\x01\0\0\0", 4), "MATLAB_class",         "t",    "OHDR"};
  std::vector<std::string> valid;
  for (const bool packed : {false, true}) {
    {
      test::Hdf5MatWriter writer(folder_ / "run.mat");
      writer.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 0.1, 0.2}, packed);
      if (packed) writer.vector<float>("q_1", MAT_C_SINGLE, MAT_T_SINGLE, {1, 2, 3}, packed);
      if (!packed) writer.structure("log", {{"q_1", {1, 2, 3}}, {"u_1", {4, 5, 6}}});
    }
    valid.push_back(read(folder_ / "run.mat"));
  }
  Mutator mutate(tokens, 15);
  for (int i = 0; i < kFileMutants / 3; ++i) {
    const std::string& origin = valid[static_cast<std::size_t>(i) % valid.size()];
    // Behind MATLAB's 512 bytes; half of the mutants keep the length, on which HDF5's addresses rest.
    std::string mutant = mutate(origin.substr(512));
    if (i % 4 < 2) mutant.resize(origin.size() - 512, '\0');
    write(folder_ / "run.mat", origin.substr(0, 512) + mutant);
    if (!survives([&] { load_recording(folder_ / "run.mat", "run.mat"); }, "mutant " + std::to_string(i))) break;
  }
}

/// Messages by themselves: many more than through files.
TEST_F(Fuzz, RosMessages) {
  CdrWriter trajectory;
  trajectory.header(5).texts({"a", "b"}).u32(1).numbers({1, 2}).numbers({}).numbers({}).numbers({3, 4}).i32(0).u32(0);
  const std::vector<std::pair<const char*, std::string>> valid{
      {"sensor_msgs/msg/JointState", test::joint_state(5, {"a", "b"}, {1, 2}, {3, 4}, {5, 6})},
      {"sensor_msgs/msg/JointState", test::joint_state(5, {"a", "b"}, {1, 2}, {}, {}, true)},
      {"std_msgs/msg/Float64MultiArray", test::float64_array({1, 2, 3})},
      {"trajectory_msgs/msg/JointTrajectory", trajectory.bytes()},
      {"control_msgs/msg/DynamicJointState",
       CdrWriter().header(1).texts({"a"}).u32(1).texts({"p", "q"}).numbers({1, 2}).bytes()},
      {"control_msgs/msg/MultiDOFCommand", CdrWriter().texts({"x"}).numbers({4}).numbers({}).bytes()}};
  Mutator mutate(kNumbers, 14);
  RosMessage message;
  for (int i = 0; i < 10 * kMutants; ++i) {
    const auto& [type, origin] = valid[static_cast<std::size_t>(i) % valid.size()];
    const std::string mutant = mutate(origin);
    const auto work = [&] {
      try {
        decode_ros_message(*find_ros_type(type), mutant, message);
      } catch (const MessageFault& fault) {
        throw InputError("message", fault.found, fault.expected);
      }
    };
    if (!survives(work, mutant)) break;
  }
}

}  // namespace
}  // namespace lacuna
