#include "scenarios/mcap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenarios/bag_writer.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::McapWriter;
using test::TemporaryFolder;
using test::two_joint_bag;
using testing::Contains;
using testing::HasSubstr;

std::string mcap_refusal(const TemporaryFolder& folder, const std::string& bytes) {
  const auto file = folder.write("bad.mcap", bytes);
  return input_error([&] { load_recording(file, "bad.mcap"); });
}

/// A schema and its channel, as they stand in a chunk.
std::string declared() {
  return McapWriter::record(0x03, McapWriter::number(1, 2) + McapWriter::text("std_msgs/msg/Float64") +
                                      McapWriter::text("ros2msg") + McapWriter::number(0, 4)) +
         McapWriter::record(0x04, McapWriter::number(1, 2) + McapWriter::number(1, 2) + McapWriter::text("/u") +
                                      McapWriter::text("cdr") + McapWriter::number(0, 4));
}

std::string mcap_message(std::uint64_t time, const std::string& data, int channel = 1) {
  return McapWriter::record(0x05, McapWriter::number(static_cast<std::uint64_t>(channel), 2) +
                                      McapWriter::number(0, 4) + McapWriter::number(time, 8) +
                                      McapWriter::number(time, 8) + data);
}

std::string number_message(std::uint64_t time, double value) {
  return mcap_message(time, test::CdrWriter().f64(value).bytes());
}

TEST(Mcap, CutOffAnywhereIsReadToItsLastWholeRecordOrRefused) {
  const TemporaryFolder folder;
  const std::string whole = McapWriter("zstd", 25).bytes(two_joint_bag());
  std::size_t read = 0, refused = 0, rows = 0;
  for (std::size_t bytes = 9; bytes < whole.size(); bytes += 7) {
    const auto file = folder.write("run.mcap", whole.substr(0, bytes));
    try {
      const auto data = load_recording(file, "run.mcap");
      ++read;
      EXPECT_GE(data->rows(), rows) << "more bytes, fewer rows";
      rows = data->rows();
    } catch (const InputError& error) {
      ++refused;
      EXPECT_EQ(rows, 0u) << "refused after less was read: " << error.what();
    }
  }
  EXPECT_GT(read, 0u);
  EXPECT_GT(refused, 0u);
  EXPECT_EQ(rows, 100u);
}

TEST(Mcap, SaysAtWhichByteItWasCutOff) {
  const TemporaryFolder folder;
  const std::string whole = McapWriter("-").bytes(two_joint_bag());
  const auto data = load_recording(folder.write("run.mcap", whole.substr(0, 6000)), "run.mcap");
  EXPECT_THAT(data->notes, Contains(HasSubstr("ends at byte 6000 within the record that begins at byte 5")));
}

TEST(Mcap, ChecksTheSumsOfChunksAndOfTheDataSection) {
  const TemporaryFolder folder;
  std::string bytes = McapWriter("").bytes(two_joint_bag());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  EXPECT_THAT(mcap_refusal(folder, bytes), HasSubstr("of the chunk, expected 0x"));
  bytes = McapWriter("-").bytes(two_joint_bag());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  EXPECT_THAT(mcap_refusal(folder, bytes), HasSubstr("record at byte"));
  // Without sums nothing is checked.
  EXPECT_NO_THROW(load_recording(folder.write("run.mcap", McapWriter("lz4", 10, false).bytes(two_joint_bag())), "run"));
}

TEST(Mcap, MayHoldRecordsThatNobodyKnowsAndNoSummary) {
  const TemporaryFolder folder;
  const std::string bytes = McapWriter().head() + McapWriter::record(0x80, "of a vendor") +
                            McapWriter::record(0x09, std::string(3000, 'a')) + declared() +
                            McapWriter::record(0x0C, "") + number_message(0, 1) + number_message(1000, 2);
  const auto data =
      load_recording(folder.write("run.mcap", bytes + McapWriter::record(0x0F, McapWriter::number(0, 4))), "run");
  EXPECT_EQ(data->columns[1], (std::vector<double>{1, 2}));
}

TEST(Mcap, IsSortedByTheTimesOfReceipt) {
  const TemporaryFolder folder;
  const std::string bytes = McapWriter().head() + declared() + number_message(3'000'000'000, 3) +
                            number_message(1'000'000'000, 1) + number_message(2'000'000'000, 2) +
                            McapWriter::record(0x0F, McapWriter::number(0, 4));
  const auto data = load_recording(folder.write("run.mcap", bytes), "run");
  EXPECT_EQ(data->columns[0], (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(data->columns[1], (std::vector<double>{1, 2, 3}));
}

/// A few bytes that claim, or unpack to, very much more.
TEST(Mcap, BombsAreRefusedBeforeTheyGoOff) {
  const TemporaryFolder folder;
  const std::string zeros(std::size_t{300} << 20, '\0');
  const std::string huge = McapWriter::chunk(zeros, "zstd", zeros.size(), 0);
  ASSERT_LT(huge.size(), 100'000u);
  EXPECT_THAT(mcap_refusal(folder, McapWriter().head() + huge),
              HasSubstr("a chunk of 314572800 bytes, expected at most"));
  EXPECT_THAT(mcap_refusal(folder, McapWriter().head() + McapWriter::chunk(zeros, "zstd", 1000, 0)),
              HasSubstr("more than 1000 bytes unpacked from zstd"));
  std::string many = McapWriter().head();
  const std::string some(std::size_t{60} << 20, '\0');
  // Chunks of one vendor's record of 60 MiB of zeros each: together more than a thousand times the file.
  const std::string vendor = McapWriter::record(0x80, some);
  for (int i = 0; i < 3; ++i) many += McapWriter::chunk(vendor, "zstd", vendor.size(), 0);
  EXPECT_THAT(mcap_refusal(folder, many), HasSubstr("more than a thousand times the file"));
}

TEST(Mcap, RefusesWhatIsNotAsSpecifiedAndNamesTheByte) {
  const TemporaryFolder folder;
  const std::string head = McapWriter().head();
  const auto at_head = "record at byte " + std::to_string(head.size());
  EXPECT_THAT(mcap_refusal(folder, "not MCAP at all"), HasSubstr("byte 0: found another beginning"));
  EXPECT_THAT(mcap_refusal(folder, test::replaced(head, "MCAP0", "MCAP1")), HasSubstr("version 0x31"));
  EXPECT_THAT(mcap_refusal(folder, McapWriter::magic() + declared()), HasSubstr("expected the header"));
  EXPECT_THAT(mcap_refusal(folder, head + std::string(50, '\0')), HasSubstr(at_head + ": found the opcode 0x00"));
  EXPECT_THAT(mcap_refusal(folder, head + number_message(0, 1)), HasSubstr("a message of channel 1"));
  EXPECT_THAT(mcap_refusal(folder, head + McapWriter::record(0x05, "abc")),
              HasSubstr("a field of 4 bytes where 1 are left"));
  EXPECT_THAT(mcap_refusal(folder, head + declared() + mcap_message(~std::uint64_t{0}, "")),
              HasSubstr("a time below 2^63"));
  EXPECT_THAT(mcap_refusal(folder, head + McapWriter::chunk(declared(), "brotli", declared().size(), 0)),
              HasSubstr("\"brotli\""));
  EXPECT_THAT(mcap_refusal(folder, head + McapWriter::chunk(declared(), "", declared().size() + 1, 0)),
              HasSubstr("as stated"));
  EXPECT_THAT(mcap_refusal(folder, head + McapWriter::chunk(declared(), "lz4", declared().size() + 1, 0)),
              HasSubstr("unpacked from lz4"));
  const std::string nested = McapWriter::chunk(declared(), "", declared().size(), 0);
  EXPECT_THAT(mcap_refusal(folder, head + McapWriter::chunk(nested, "", nested.size(), 0)),
              HasSubstr("0x06 within a chunk"));
  std::string broken = McapWriter::chunk(declared(), "zstd", declared().size(), 0);
  const std::size_t body = broken.size() - McapWriter::packed(declared(), "zstd").size();
  broken[body] = static_cast<char>(~broken[body]);  // the first byte of zstd's magic
  EXPECT_THAT(mcap_refusal(folder, head + broken), HasSubstr("zstd"));
}

}  // namespace
}  // namespace lacuna
