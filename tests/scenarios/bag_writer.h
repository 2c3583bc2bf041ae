// Writes messages in CDR, files in MCAP and bags in SQLite, whole or spoiled, for the tests of their readers.
//
// Written from the specifications alone (OMG CDR, mcap.dev/spec, the tables of rosbag2): nothing is shared with the
// readers but the libraries that pack.
#pragma once

#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace lacuna::test {

class CdrWriter {
 public:
  explicit CdrWriter(bool big_endian = false)
      : big_(big_endian), out_{0, static_cast<char>(big_endian ? 0 : 1), 0, 0} {}

  CdrWriter& u32(std::uint32_t x) { return whole(x, 4); }
  CdrWriter& i32(std::int32_t x) { return u32(static_cast<std::uint32_t>(x)); }
  CdrWriter& f32(float x) { return u32(std::bit_cast<std::uint32_t>(x)); }
  CdrWriter& f64(double x) { return whole(std::bit_cast<std::uint64_t>(x), 8); }
  CdrWriter& text(const std::string& x) {
    u32(static_cast<std::uint32_t>(x.size() + 1));
    out_ += x;
    out_ += '\0';
    return *this;
  }
  CdrWriter& texts(const std::vector<std::string>& all) {
    u32(static_cast<std::uint32_t>(all.size()));
    for (const std::string& x : all) text(x);
    return *this;
  }
  CdrWriter& numbers(const std::vector<double>& all) {
    u32(static_cast<std::uint32_t>(all.size()));
    for (const double x : all) f64(x);
    return *this;
  }
  CdrWriter& header(std::int64_t stamp_ns, const std::string& frame = "base") {
    return i32(static_cast<std::int32_t>(stamp_ns / 1'000'000'000))
        .u32(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000))
        .text(frame);
  }
  std::string bytes() const { return out_; }

 private:
  CdrWriter& whole(std::uint64_t x, std::size_t bytes) {
    while ((out_.size() - 4) % bytes != 0) out_ += '\0';
    for (std::size_t i = 0; i < bytes; ++i) out_ += static_cast<char>(x >> (8 * (big_ ? bytes - 1 - i : i)));
    return *this;
  }

  bool big_;
  std::string out_;
};

inline std::string joint_state(std::int64_t stamp_ns, const std::vector<std::string>& names,
                               const std::vector<double>& position, const std::vector<double>& velocity = {},
                               const std::vector<double>& effort = {}, bool big_endian = false) {
  return CdrWriter(big_endian)
      .header(stamp_ns)
      .texts(names)
      .numbers(position)
      .numbers(velocity)
      .numbers(effort)
      .bytes();
}

inline std::string float64_array(const std::vector<double>& data) {
  return CdrWriter()
      .u32(1)
      .text("joints")
      .u32(static_cast<std::uint32_t>(data.size()))
      .u32(1)
      .u32(0)
      .numbers(data)
      .bytes();
}

struct BagTopic {
  std::string name, type, encoding = "cdr";
};
struct BagMessage {
  std::size_t topic = 0;  ///< index into the topics
  std::int64_t log_ns = 0;
  std::string data;
};
struct Bag {
  std::vector<BagTopic> topics;
  std::vector<BagMessage> messages;
};

inline constexpr std::int64_t kBagStart = 1'700'000'000'000'000'000;  ///< ns
inline constexpr std::int64_t kMillisecond = 1'000'000;               ///< ns

/// Two joints at 100 Hz whose headers are stamped 2 ms before their receipt, and commands of both at 50 Hz, from
/// 0.1 s on. q_a = .01 i, q_b = -q_a, their rates 1 and -1; command k is {k, -k}.
inline Bag two_joint_bag(int samples = 100) {
  Bag out;
  out.topics = {{"/joint_states", "sensor_msgs/msg/JointState"},
                {"/valves", "std_msgs/msg/Float64MultiArray"},
                {"/chatter", "std_msgs/msg/String"}};
  for (int i = 0; i < samples; ++i) {
    const std::int64_t now = kBagStart + 10 * kMillisecond * i;
    const double q = 0.01 * i;
    out.messages.push_back({0, now + 2 * kMillisecond, joint_state(now, {"a", "b"}, {q, -q}, {1.0, -1.0})});
    if (i >= 10 && i % 2 == 0) out.messages.push_back({1, now, float64_array({double(i), double(-i)})});
    if (i % 10 == 0) out.messages.push_back({2, now, CdrWriter().text("hello").bytes()});
  }
  return out;
}

class McapWriter {
 public:
  explicit McapWriter(std::string packing = "", std::size_t messages_a_chunk = 0, bool checksums = true)
      : packing_(std::move(packing)), per_chunk_(messages_a_chunk), checksums_(checksums) {}

  static std::string magic() { return std::string("\x89MCAP0\r\n", 8); }
  static std::string number(std::uint64_t x, int bytes) {
    std::string out;
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(x >> (8 * i));
    return out;
  }
  static std::string text(const std::string& x) { return number(x.size(), 4) + x; }
  static std::string record(unsigned opcode, const std::string& content) {
    return number(opcode, 1) + number(content.size(), 8) + content;
  }
  static std::uint32_t checksum(const std::string& x) {
    return static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(x.data()), static_cast<uInt>(x.size())));
  }
  static std::string packed(const std::string& plain, const std::string& packing) {
    std::string out;
    if (packing == "zstd") {
      out.resize(ZSTD_compressBound(plain.size()));
      out.resize(ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), 3));
    } else if (packing == "lz4") {
      out.resize(LZ4F_compressFrameBound(plain.size(), nullptr));
      out.resize(LZ4F_compressFrame(out.data(), out.size(), plain.data(), plain.size(), nullptr));
    } else {
      return plain;
    }
    return out;
  }
  static std::string chunk(const std::string& plain, const std::string& packing, std::uint64_t stated_size,
                           std::uint32_t stated_checksum) {
    const std::string body = packed(plain, packing);
    return record(0x06, number(0, 8) + number(0, 8) + number(stated_size, 8) + number(stated_checksum, 4) +
                            text(packing) + number(body.size(), 8) + body);
  }

  std::string head() const { return magic() + record(0x01, text("ros2") + text("lacuna's tests")); }

  /// Everything; one chunk of all, or chunks of so many messages; `packing` "-": no chunks.
  std::string bytes(const Bag& bag) const {
    std::string data, plain;
    for (std::size_t i = 0; i < bag.topics.size(); ++i) {
      const BagTopic& topic = bag.topics[i];
      plain += record(0x03, number(i + 1, 2) + text(topic.type) + text("ros2msg") + text("float64 unread"));
      plain += record(0x04, number(i, 2) + number(i + 1, 2) + text(topic.name) + text(topic.encoding) + number(0, 4));
    }
    std::size_t in_chunk = 0;
    const auto close = [&] {
      if (plain.empty()) return;
      data += packing_ == "-" ? plain : chunk(plain, packing_, plain.size(), checksums_ ? checksum(plain) : 0);
      data += record(0x07, number(0, 2) + number(0, 4));  // an index that nobody needs
      plain.clear(), in_chunk = 0;
    };
    for (const BagMessage& message : bag.messages) {
      const auto time = static_cast<std::uint64_t>(message.log_ns);
      plain += record(0x05, number(message.topic, 2) + number(0, 4) + number(time, 8) + number(time, 8) + message.data);
      if (++in_chunk == per_chunk_) close();
    }
    close();
    const std::string front = head() + data;
    return front + record(0x0F, number(checksums_ ? checksum(front) : 0, 4)) +
           record(0x02, number(0, 8) + number(0, 8) + number(0, 4)) + magic();
  }

 private:
  std::string packing_;
  std::size_t per_chunk_;
  bool checksums_;
};

/// The tables that rosbag2 writes.
inline void write_db3(const std::filesystem::path& file, const Bag& bag, bool packed_messages = false) {
  std::filesystem::remove(file);
  sqlite3* db = nullptr;
  if (sqlite3_open(file.c_str(), &db) != SQLITE_OK) throw std::runtime_error("no database");
  const auto run = [&](const char* text) {
    if (sqlite3_exec(db, text, nullptr, nullptr, nullptr) != SQLITE_OK) throw std::runtime_error(sqlite3_errmsg(db));
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT "
      "NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT "
      "NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC); BEGIN;");
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO topics VALUES (?, ?, ?, ?, '')", -1, &insert, nullptr);
  for (std::size_t i = 0; i < bag.topics.size(); ++i) {
    sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(i + 1));
    int place = 2;
    for (const std::string* text : {&bag.topics[i].name, &bag.topics[i].type, &bag.topics[i].encoding})
      sqlite3_bind_text(insert, place++, text->c_str(), -1, SQLITE_STATIC);
    sqlite3_step(insert), sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  sqlite3_prepare_v2(db, "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", -1, &insert, nullptr);
  for (const BagMessage& message : bag.messages) {
    const std::string data = McapWriter::packed(message.data, packed_messages ? "zstd" : "");
    sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(message.topic + 1));
    sqlite3_bind_int64(insert, 2, message.log_ns);
    sqlite3_bind_blob(insert, 3, data.data(), static_cast<int>(data.size()), SQLITE_STATIC);
    sqlite3_step(insert), sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  run("COMMIT");
  sqlite3_close(db);
}

/// metadata.yaml as rosbag2 writes it, so far as it is read.
inline std::string bag_metadata(const std::string& storage, const std::vector<std::string>& files,
                                const std::string& mode = "", const std::string& format = "") {
  std::string out =
      "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: " + storage +
      "\n  duration:\n    nanoseconds: 990000000\n  starting_time:\n    nanoseconds_since_epoch: " +
      std::to_string(kBagStart) +
      "\n  message_count: 3\n  topics_with_message_count:\n    - topic_metadata:\n        name: "
      "/joint_states\n        type: sensor_msgs/msg/JointState\n        serialization_format: cdr\n        "
      "offered_qos_profiles: \"- history: 3\\n  depth: 0\"\n      message_count: 100\n  compression_format: \"" +
      format + "\"\n  compression_mode: \"" + mode + "\"\n  relative_file_paths:\n";
  for (const std::string& file : files) out += "    - " + file + "\n";
  return out;
}

}  // namespace lacuna::test
