#include "scenarios/mcap.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>

#include "scenarios/decompress.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kRecordHead = 1 + 8;
/// Of one record outside of chunks, and of what one chunk unpacks to. Writers make chunks of some MiB.
constexpr std::size_t kMaxRecord = std::size_t{256} << 20;
/// What all chunks together may unpack to: this, and so many times the file's size.
constexpr std::uintmax_t kFreeUnpacked = std::uintmax_t{64} << 20, kMaxPackRatio = 1024;

enum Opcode : unsigned {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0F
};

/// The file ended where more was announced.
struct CutOff {};

/// A file from its beginning to its end, with the checksum of all that went by.
class Stream {
 public:
  Stream(const std::filesystem::path& file, const std::string& shown)
      : shown_(shown), descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail();
  }
  ~Stream() { ::close(descriptor_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  std::uintmax_t at() const { return at_; }
  std::uint32_t checksum() const { return checksum_; }

  /// Replaces `out`; throws CutOff where the file has less.
  void read(std::string& out, std::size_t bytes) {
    out.clear();
    while (out.size() < bytes) {
      const std::size_t done = out.size(), block = std::min(bytes - done, kBlock);
      out.resize(done + block);
      std::size_t got = 0;
      while (got < block) {
        const ssize_t now = ::read(descriptor_, out.data() + done + got, block - got);
        if (now < 0 && errno == EINTR) continue;
        if (now < 0) fail();
        if (now == 0) throw CutOff{};
        got += static_cast<std::size_t>(now);
      }
      checksum_ = static_cast<std::uint32_t>(
          crc32(checksum_, reinterpret_cast<const Bytef*>(out.data() + done), static_cast<uInt>(block)));
      at_ += block;
    }
  }

  /// Reads on without keeping anything.
  void pass(std::uintmax_t bytes) {
    for (std::string block; bytes > 0; bytes -= block.size())
      read(block, static_cast<std::size_t>(std::min<std::uintmax_t>(bytes, kBlock)));
  }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 20;
  [[noreturn]] void fail() const { throw InputError(printable(shown_), std::strerror(errno), "a readable recording"); }

  const std::string& shown_;
  int descriptor_;
  std::uintmax_t at_ = 0;
  std::uint32_t checksum_ = 0;
};

/// Fields of one record, in little endian.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}

  std::uint64_t whole(std::size_t bytes) {
    const std::string_view taken = take(bytes);
    std::uint64_t out = 0;
    for (std::size_t i = bytes; i-- > 0;) out = out << 8 | static_cast<unsigned char>(taken[i]);
    return out;
  }
  std::string_view text() { return take(whole(4)); }
  std::string_view bytes() { return take(whole(8)); }
  std::string_view rest() const { return rest_; }
  std::string_view take(std::uint64_t bytes) {
    if (bytes > rest_.size())
      throw MessageFault(fmt::format("a field of {} bytes where {} are left", bytes, rest_.size()),
                         "a record that holds its fields");
    const std::string_view out = rest_.substr(0, static_cast<std::size_t>(bytes));
    rest_.remove_prefix(static_cast<std::size_t>(bytes));
    return out;
  }

 private:
  std::string_view rest_;
};

class McapReader {
 public:
  McapReader(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits,
             TopicTable& table, std::vector<std::string>& notes)
      : shown_(shown),
        table_(table),
        notes_(notes),
        file_bytes_(check_regular_file(file, shown, "a recording in MCAP", limits.bytes)),
        stream_(file, shown) {
    may_unpack_ = kFreeUnpacked + std::min(limits.bytes, kMaxPackRatio * file_bytes_);
  }

  void run() {
    try {
      read_magic();
      while (read_record()) {
      }
    } catch (const CutOff&) {
      if (!header_seen_) throw InputError(place(), fmt::format("an end at byte {}", file_bytes_), "a file in MCAP");
      notes_.push_back(fmt::format(
          "{}: ends at byte {} within the record that begins at byte {}: cut off; what stands before is used",
          printable(shown_), file_bytes_, record_));
    } catch (const MessageFault& fault) {
      throw InputError(place(), fault.found, fault.expected);
    }
  }

 private:
  std::string place() const { return fmt::format("{}: record at byte {}", printable(shown_), record_); }

  void read_magic() {
    std::string magic;
    stream_.read(magic, kMcapMagic.size());
    if (magic == kMcapMagic) return;
    const bool other = magic.substr(0, 5) == kMcapMagic.substr(0, 5);
    throw InputError(
        printable(shown_) + ": byte 0",
        other ? fmt::format("MCAP of version 0x{:02x}", static_cast<unsigned char>(magic[5])) : "another beginning",
        "MCAP of version 0x30 (\\x89MCAP0\\r\\n)");
  }

  /// False after the data section.
  bool read_record() {
    record_ = stream_.at();
    const std::uint32_t checksum = stream_.checksum();
    stream_.read(content_, kRecordHead);
    Fields head(content_);
    const auto opcode = static_cast<unsigned>(head.whole(1));
    const std::uint64_t bytes = head.whole(8);
    if (opcode == 0) throw MessageFault("the opcode 0x00", "a record of MCAP");
    if (!header_seen_ && opcode != kHeader)
      throw MessageFault(fmt::format("the opcode 0x{:02x}", opcode), "the header, 0x01");
    header_seen_ = true;
    if (bytes > file_bytes_ - stream_.at()) throw CutOff{};
    if (opcode == kFooter) return false;
    if (opcode == kHeader) {
      stream_.pass(bytes);
      section_ = stream_.at(), section_checksum_ = stream_.checksum();
      return true;
    }
    if (opcode != kSchema && opcode != kChannel && opcode != kMessage && opcode != kChunk && opcode != kDataEnd) {
      stream_.pass(bytes);
      return true;
    }
    if (bytes > kMaxRecord)
      throw MessageFault(fmt::format("a record of {} bytes", bytes), fmt::format("at most {}", kMaxRecord));
    stream_.read(content_, static_cast<std::size_t>(bytes));
    if (opcode == kChunk) {
      read_chunk(Fields(content_));
    } else if (opcode != kDataEnd) {
      take(opcode, Fields(content_));
    } else {
      check_section(static_cast<std::uint32_t>(Fields(content_).whole(4)), checksum);
      return false;
    }
    return true;
  }

  /// Writers count from the file's first byte, the specification's words from behind the header: either will do.
  void check_section(std::uint32_t stated, std::uint32_t from_start) const {
    // Of two stretches A and B: sum(AB) = shifted(sum(A), length of B) ^ sum(B).
    const auto length = static_cast<z_off_t>(record_ - section_);
    const auto section = static_cast<std::uint32_t>(crc32_combine(section_checksum_, 0, length)) ^ from_start;
    if (stated != section) expect_checksum(stated, from_start, "the data section");
  }

  static void expect_checksum(std::uint32_t stated, std::uint32_t made, const char* what) {
    if (stated != 0 && stated != made)
      throw MessageFault(fmt::format("the checksum 0x{:08x} of {}", made, what),
                         fmt::format("0x{:08x}, as stated: the file is damaged", stated));
  }

  void read_chunk(Fields fields) {
    fields.take(2 * 8);  // first and last time
    const std::uint64_t size = fields.whole(8);
    const auto stated = static_cast<std::uint32_t>(fields.whole(4));
    const std::string_view packing = fields.text();
    const std::string_view packed = fields.bytes();
    if (size > kMaxRecord)
      throw MessageFault(fmt::format("a chunk of {} bytes", size), fmt::format("at most {}", kMaxRecord));
    if (size > may_unpack_)
      throw MessageFault("chunks that unpack to more than a thousand times the file", "a recording");
    may_unpack_ -= size;
    std::string unpacked;
    std::string_view records = packed;
    if (packing == "zstd") {
      records = unpacked = unpack_zstd(packed, static_cast<std::size_t>(size), kMaxRecord);
    } else if (packing == "lz4") {
      records = unpacked = unpack_lz4(packed, static_cast<std::size_t>(size), kMaxRecord);
    } else if (!packing.empty()) {
      throw MessageFault("a chunk packed by " + quoted(std::string(packing)), "none, lz4 or zstd");
    }
    if (records.size() != size)
      throw MessageFault(fmt::format("a chunk of {} bytes", records.size()), fmt::format("{}, as stated", size));
    expect_checksum(stated,
                    static_cast<std::uint32_t>(
                        crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size()))),
                    "the chunk");
    for (Fields inner(records); !inner.rest().empty();) {
      const auto opcode = static_cast<unsigned>(inner.whole(1));
      if (opcode == kChunk || opcode == 0)
        throw MessageFault(fmt::format("the opcode 0x{:02x} within a chunk", opcode), "schemas, channels and messages");
      take(opcode, Fields(inner.bytes()));
    }
  }

  /// A record that may stand in a chunk or outside.
  void take(unsigned opcode, Fields fields) {
    if (opcode == kSchema) {
      const auto id = static_cast<std::uint16_t>(fields.whole(2));
      if (id != 0) schemas_[id] = std::string(fields.text());
    } else if (opcode == kChannel) {
      take_channel(fields);
    } else if (opcode == kMessage) {
      const auto id = static_cast<std::uint16_t>(fields.whole(2));
      fields.whole(4);
      const std::uint64_t log_time = fields.whole(8);
      fields.whole(8);
      const auto channel = channels_.find(id);
      if (channel == channels_.end())
        throw MessageFault(fmt::format("a message of channel {}", id), "a channel declared before");
      if (log_time > std::uint64_t{0x7FFFFFFFFFFFFFFF})
        throw MessageFault(fmt::format("the time {} ns", log_time), "a time below 2^63 ns");
      if (channel->second.handle >= 0)
        table_.add(channel->second.handle, static_cast<std::int64_t>(log_time), fields.rest());
    }
  }

  struct Channel {
    std::uint16_t schema = 0;
    std::string topic;
    int handle = -1;
  };

  void take_channel(Fields fields) {
    const auto id = static_cast<std::uint16_t>(fields.whole(2));
    Channel channel{static_cast<std::uint16_t>(fields.whole(2)), std::string(fields.text()), -1};
    const std::string encoding(fields.text());
    if (const auto known = channels_.find(id); known != channels_.end()) {
      if (known->second.schema != channel.schema || known->second.topic != channel.topic)
        throw MessageFault(fmt::format("channel {} a second time as another", id), "one channel an id");
      return;
    }
    const auto schema = schemas_.find(channel.schema);
    if (schema == schemas_.end() && channel.schema != 0)
      throw MessageFault(fmt::format("a channel of schema {}", channel.schema), "a schema declared before");
    channel.handle = table_.declare(channel.topic, schema == schemas_.end() ? "no schema" : schema->second, encoding);
    channels_[id] = std::move(channel);
  }

  const std::string& shown_;
  TopicTable& table_;
  std::vector<std::string>& notes_;
  std::uintmax_t file_bytes_, may_unpack_ = 0;
  Stream stream_;
  std::uintmax_t record_ = 0;   ///< byte at which the record being read begins
  std::uintmax_t section_ = 0;  ///< byte at which the data section begins
  std::uint32_t section_checksum_ = 0;
  bool header_seen_ = false;
  std::string content_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, Channel> channels_;
};

}  // namespace

void read_mcap(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits,
               TopicTable& table, std::vector<std::string>& notes) {
  McapReader(file, shown, limits, table, notes).run();
}

}  // namespace lacuna
