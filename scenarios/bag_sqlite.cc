#include "scenarios/bag_sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <map>
#include <memory>

#include "scenarios/decompress.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr int kMaxMessage = 64 << 20;  ///< bytes
/// Steps of SQLite's machine that a whole reading may take: a message takes some ten, and at least twenty bytes.
constexpr std::uintmax_t kFreeSteps = 10'000'000, kStepsAByte = 4;
constexpr int kStepsACall = 10'000;
/// Rows of `topics`.
constexpr int kMaxTopicRows = 4096;
constexpr int kMaxNameBytes = 4096;
const char* const kBagExpected = "a bag of ROS 2 in SQLite (tables topics and messages)";

using Database = std::unique_ptr<sqlite3, int (*)(sqlite3*)>;
using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

/// "file:/a%20b.db3?..." for a path with any bytes.
std::string read_only_address(const std::filesystem::path& file) {
  std::string out = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
                       c == '.' || c == '_' || c == '-';
    out += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  // `immutable`: neither locks nor logs, so that nothing appears beside the file.
  return out + "?mode=ro&immutable=1";
}

class BagReader {
 public:
  BagReader(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits, bool packed,
            TopicTable& table)
      : shown_(shown), packed_(packed), table_(table), database_(nullptr, &sqlite3_close) {
    const std::uintmax_t bytes = check_regular_file(file, shown, kBagExpected, limits.bytes);
    calls_left_ = (kFreeSteps + kStepsAByte * bytes) / kStepsACall;
    bytes_left_ = bytes, may_unpack_ = limits.bytes;
    refuse_unclosed(file);
    sqlite3* opened = nullptr;
    const int state = sqlite3_open_v2(read_only_address(file).c_str(), &opened,
                                      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(opened);
    if (opened == nullptr) throw std::bad_alloc();
    if (state != SQLITE_OK) refuse(sqlite3_errmsg(opened));
    restrain();
  }

  void run() {
    expect_tables();
    read_topics();
    read_messages();
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const char* expected = kBagExpected) const {
    throw InputError(printable(shown_), printable(found), expected);
  }

  /// What a database says of itself is a stranger's word.
  void restrain() {
    sqlite3* const db = database_.get();
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kMaxMessage);
    sqlite3_limit(db, SQLITE_LIMIT_SQL_LENGTH, 1 << 16);
    sqlite3_limit(db, SQLITE_LIMIT_COLUMN, 64);
    sqlite3_limit(db, SQLITE_LIMIT_EXPR_DEPTH, 20);
    sqlite3_limit(db, SQLITE_LIMIT_ATTACHED, 0);
    sqlite3_progress_handler(
        db, kStepsACall, [](void* self) { return static_cast<BagReader*>(self)->one_call_less(); }, this);
  }
  int one_call_less() { return calls_left_ == 0 ? 1 : (--calls_left_, 0); }

  /// A recorder that was killed leaves its last messages beside the file.
  void refuse_unclosed(const std::filesystem::path& file) const {
    for (const char* end : {"-wal", "-journal"}) {
      std::error_code error;
      const std::uintmax_t bytes = std::filesystem::file_size(file.string() + end, error);
      if (!error && bytes > 0)
        refuse(fmt::format("{} bytes beside it in {}{}: it was not closed", bytes, file.filename().string(), end),
               "a closed bag: sqlite3 FILE.db3 'PRAGMA journal_mode=DELETE' closes it");
    }
  }

  Statement prepared(const char* text) const {
    sqlite3_stmt* made = nullptr;
    const int state = sqlite3_prepare_v2(database_.get(), text, -1, &made, nullptr);
    Statement out(made, &sqlite3_finalize);
    if (state != SQLITE_OK) refuse(sqlite3_errmsg(database_.get()));
    return out;
  }

  /// False after the last row.
  bool next(const Statement& statement) const {
    const int state = sqlite3_step(statement.get());
    if (state == SQLITE_ROW) return true;
    if (state == SQLITE_DONE) return false;
    if (state == SQLITE_INTERRUPT) refuse("a database that takes more steps than its size explains");
    if (state == SQLITE_NOMEM) throw std::bad_alloc();
    refuse(state == SQLITE_TOOBIG ? fmt::format("a message of more than {} bytes", kMaxMessage)
                                  : sqlite3_errmsg(database_.get()));
  }

  std::string text_of(const Statement& statement, int column) const {
    const unsigned char* text = sqlite3_column_text(statement.get(), column);
    const int bytes = sqlite3_column_bytes(statement.get(), column);
    if (bytes > kMaxNameBytes) refuse(fmt::format("a name of {} bytes in topics", bytes));
    return text == nullptr ? "" : std::string(reinterpret_cast<const char*>(text), static_cast<std::size_t>(bytes));
  }

  /// Tables, not views or modules that compute their rows.
  void expect_tables() const {
    const Statement found = prepared(
        "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages') AND rootpage > 0");
    if (!next(found) || sqlite3_column_int(found.get(), 0) != 2) refuse("no tables topics and messages");
  }

  void read_topics() {
    const Statement rows = prepared("SELECT id, name, type, serialization_format FROM topics");
    for (int row = 0; next(rows); ++row) {
      if (row == kMaxTopicRows) refuse(fmt::format("more than {} topics", kMaxTopicRows));
      const std::string name = text_of(rows, 1);
      handles_[sqlite3_column_int64(rows.get(), 0)] = table_.declare(name, text_of(rows, 2), text_of(rows, 3));
    }
  }

  void read_messages() {
    const Statement rows = prepared("SELECT topic_id, timestamp, data FROM messages");
    for (std::uintmax_t row = 1; next(rows); ++row) {
      // Rows that share their pages would make a small file endless.
      const auto bytes = static_cast<std::uintmax_t>(sqlite3_column_bytes(rows.get(), 2));
      if (bytes > bytes_left_) refuse("messages of more bytes than the file has");
      bytes_left_ -= bytes;
      const auto handle = handles_.find(sqlite3_column_int64(rows.get(), 0));
      if (handle == handles_.end())
        refuse(fmt::format("message {} of topic {}", row, sqlite3_column_int64(rows.get(), 0)),
               "a topic that is listed");
      if (handle->second < 0) continue;
      if (sqlite3_column_type(rows.get(), 1) != SQLITE_INTEGER || sqlite3_column_type(rows.get(), 2) != SQLITE_BLOB)
        refuse(fmt::format("message {} without a time or without data", row));
      const std::int64_t time = sqlite3_column_int64(rows.get(), 1);
      const auto* data = static_cast<const char*>(sqlite3_column_blob(rows.get(), 2));
      const std::string_view message(data == nullptr ? "" : data,
                                     data == nullptr ? 0 : static_cast<std::size_t>(bytes));
      if (packed_)
        table_.add(handle->second, time, unpacked(message, row));
      else
        table_.add(handle->second, time, message);
    }
  }

  std::string unpacked(std::string_view message, std::uintmax_t row) {
    try {
      std::string out = unpack_zstd(message, std::string::npos, kMaxMessage);
      if (out.size() > may_unpack_)
        throw MessageFault("messages that unpack to more than the limit of a recording", "a shorter one");
      may_unpack_ -= out.size();
      return out;
    } catch (const MessageFault& fault) {
      throw InputError(fmt::format("{}: message {}", printable(shown_), row), fault.found, fault.expected);
    }
  }

  const std::string& shown_;
  bool packed_;
  TopicTable& table_;
  Database database_;
  std::uintmax_t calls_left_ = 0, bytes_left_ = 0, may_unpack_ = 0;
  std::map<sqlite3_int64, int> handles_;
};

}  // namespace

void read_bag_sqlite(const std::filesystem::path& file, const std::string& shown, const RecordingLimits& limits,
                     bool packed, TopicTable& table) {
  BagReader(file, shown, limits, packed, table).run();
}

}  // namespace lacuna
