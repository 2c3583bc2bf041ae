// Recordings as CSV: one pass over the file in blocks, every refusal with its line and column.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_formats.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
/// Rows whose memory is asked for before they are seen: a file's size is a claim, not a promise.
constexpr std::size_t kMaxRowsAhead = std::size_t{1} << 20;

/// Lines of a file, read in blocks: holds one block and one line, whatever the file's size.
class LineReader {
 public:
  /// `bytes`: of the file, so that a small one takes little.
  LineReader(const std::filesystem::path& file, std::string name, std::size_t max_line, std::uintmax_t bytes)
      : name_(std::move(name)),
        max_line_(max_line),
        block_(std::clamp<std::uintmax_t>(bytes + 1, 4096, kBlockBytes)),
        descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw InputError(printable(name_), std::strerror(errno), "a readable recording");
  }
  ~LineReader() { ::close(descriptor_); }
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// The next line without its end ("\n" or "\r\n"); false after the last. Valid until the next call.
  bool next(std::string_view& line) {
    std::size_t searched = 0;
    while (true) {
      const char* from = buffer_.data() + begin_;
      const void* end = std::memchr(from + searched, '\n', end_ - begin_ - searched);
      if (end != nullptr) {
        const auto length = static_cast<std::size_t>(static_cast<const char*>(end) - from);
        begin_ += length + 1;
        return deliver(line, from, length, true);
      }
      searched = end_ - begin_;
      if (searched > max_line_) refuse_length();
      if (fill()) continue;
      if (searched == 0) return false;
      begin_ = end_;
      return deliver(line, buffer_.data() + end_ - searched, searched, false);
    }
  }

  std::size_t number() const { return number_; }   ///< of the line delivered last, from 1
  bool terminated() const { return terminated_; }  ///< whether that line ended with a line end

 private:
  bool deliver(std::string_view& line, const char* from, std::size_t length, bool terminated) {
    if (length > max_line_) refuse_length();
    ++number_;
    terminated_ = terminated;
    if (terminated && length > 0 && from[length - 1] == '\r') --length;
    line = {from, length};
    return true;
  }

  /// Moves the unread rest to the front and reads on; false at the end of the file.
  bool fill() {
    if (begin_ > 0) std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    if (buffer_.size() < end_ + block_) buffer_.resize(end_ + block_);
    ssize_t got = 0;
    do {
      got = ::read(descriptor_, buffer_.data() + end_, block_);
    } while (got < 0 && errno == EINTR);
    if (got < 0) throw InputError(printable(name_), std::strerror(errno), "a readable recording");
    end_ += static_cast<std::size_t>(got);
    return got > 0;
  }

  [[noreturn]] void refuse_length() const {
    throw InputError(fmt::format("{}:{}", printable(name_), number_ + 1),
                     fmt::format("a line of more than {} bytes", max_line_), "lines of comma-separated numbers");
  }

  std::string name_;
  std::size_t max_line_, block_;
  int descriptor_;
  std::vector<char> buffer_ = std::vector<char>(block_);
  std::size_t begin_ = 0, end_ = 0, number_ = 0;
  bool terminated_ = false;
};

/// Powers of ten that a double holds exactly.
constexpr double kPowersOfTen[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                   1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// Reads "-12.345" followed by a comma or the end, the form of nearly every field; nullptr for anything else.
/// Up to 15 digits are exact in a double and so is the power of ten: their quotient is the nearest double.
const char* read_short_decimal(const char* at, const char* end, double& value) {
  const bool negative = *at == '-';
  if (negative) ++at;
  std::uint64_t digits = 0;
  const char* const first = at;
  const char* point = nullptr;
  for (; at != end; ++at) {
    const auto digit = static_cast<unsigned char>(*at - '0');
    if (digit < 10) {
      digits = 10 * digits + digit;
    } else if (*at == '.' && point == nullptr) {
      point = at;
    } else {
      break;
    }
  }
  const auto count = at - first - (point != nullptr ? 1 : 0);
  if (count == 0 || count > 15 || (at != end && *at != ',')) return nullptr;
  const auto decimals = point != nullptr ? at - point - 1 : 0;
  const double magnitude = static_cast<double>(digits) / kPowersOfTen[decimals];
  value = negative ? -magnitude : magnitude;
  return at;
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Takes the next header field off the front of `line`, quotes undone.
std::string take_header_field(std::string_view& line, const std::string& where) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  if (line.empty() || line.front() != '"') {
    const std::size_t comma = line.find(',');
    std::string name(trimmed(line.substr(0, comma)));
    line.remove_prefix(std::min(comma, line.size()));
    return name;
  }
  std::string name;
  line.remove_prefix(1);
  while (true) {
    const std::size_t quote = line.find('"');
    if (quote == std::string_view::npos) throw InputError(where, "a quote that is not closed", "\"name\"");
    name += line.substr(0, quote);
    line.remove_prefix(quote + 1);
    if (line.empty() || line.front() != '"') break;
    name += '"';
    line.remove_prefix(1);
  }
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  if (!line.empty() && line.front() != ',') throw InputError(where, "text after a closing quote", "a comma");
  return std::string(trimmed(name));
}

class CsvParser {
 public:
  CsvParser(const std::filesystem::path& file, std::string name, const RecordingLimits& limits, std::uintmax_t bytes)
      : name_(std::move(name)), limits_(limits), bytes_(bytes), lines_(file, name_, limits.line_bytes, bytes) {}

  Recording parse() {
    read_header();
    std::string_view line;
    while (lines_.next(line)) {
      if (trimmed(line).empty()) {
        ++empty_lines_;
        continue;
      }
      if (empty_lines_ > 0)
        throw InputError(place(lines_.number() - 1), "an empty line before the last", row_expected());
      if (rows_ == capacity_) grow(line.size());
      read_row(line);
      ++rows_;
    }
    if (rows_ == 0) throw InputError(printable(name_), "a header without rows", "rows of numbers");
    for (auto& column : recording_.columns) column.resize(rows_);
    recording_.file = name_;
    return std::move(recording_);
  }

 private:
  std::string place(std::size_t line) const { return fmt::format("{}:{}", printable(name_), line); }
  std::string row_expected() const { return fmt::format("a row of {} numbers", recording_.names.size()); }

  void read_header() {
    std::string_view line;
    if (!lines_.next(line)) throw InputError(printable(name_), "an empty file", "a header line");
    if (line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    const std::size_t bad = find_invalid_utf8(line);
    if (bad != std::string_view::npos)
      throw InputError(place(1), fmt::format("the byte 0x{:02x}", static_cast<unsigned char>(line[bad])),
                       "a header line of column names");
    const std::string where = place(1);
    while (true) {
      if (recording_.names.size() == limits_.columns)
        throw InputError(where, fmt::format("more than {} columns", limits_.columns), "fewer columns");
      recording_.names.push_back(take_header_field(line, where));
      if (line.empty()) break;
      line.remove_prefix(1);
    }
    check_names(where);
    recording_.columns.resize(recording_.names.size());
    cursors_.resize(recording_.names.size());
  }

  void check_names(const std::string& where) const {
    const auto& names = recording_.names;
    if (std::all_of(names.begin(), names.end(), [](const std::string& n) { return parse_number(n).has_value(); }))
      throw InputError(where, "numbers", "a header line of column names");
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i].empty())
        throw InputError(where, fmt::format("an empty name of column {}", i + 1), "a name for every column");
    auto sorted = names;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
      throw InputError(where, "the column " + quoted(*twice) + " twice", "each column name once");
  }

  void grow(std::size_t line_bytes) {
    const std::size_t expected = static_cast<std::size_t>(bytes_ / std::max<std::size_t>(line_bytes, 2)) + 16;
    capacity_ = capacity_ == 0 ? std::min(expected, kMaxRowsAhead) : 2 * capacity_;
    for (std::size_t c = 0; c < cursors_.size(); ++c) {
      recording_.columns[c].resize(capacity_);
      cursors_[c] = recording_.columns[c].data();
    }
  }

  void put(std::size_t column, double value) {
    if (std::isnan(value)) ++recording_.missing;
    cursors_[column][rows_] = value;
  }

  void read_row(std::string_view line) {
    const char* at = line.data();
    const char* const end = at + line.size();
    const std::size_t count = cursors_.size();
    std::size_t column = 0;
    while (true) {
      while (at != end && is_blank(*at)) ++at;
      double value = kMissing;
      const char* next = at;
      if (at != end && *at != ',') next = read_field(at, end, column, value);
      put(column, value);
      ++column;
      if (next == end) break;
      at = next + 1;
      if (column == count) refuse_surplus(line);
    }
    if (!lines_.terminated() && column < count) {
      // Cut in mid-line: the last number present may have lost digits.
      if (!std::isnan(cursors_[column - 1][rows_])) put(column - 1, kMissing);
      recording_.cut = true;
    }
    for (; column < count; ++column) put(column, kMissing);
  }

  /// Reads one number that begins at `at`; returns where its field ends (a comma or `end`).
  const char* read_field(const char* at, const char* end, std::size_t column, double& value) {
    if (const char* next = read_short_decimal(at, end, value)) return next;
    const char* begin = *at == '+' ? at + 1 : at;
    const auto [stop, code] = std::from_chars(begin, end, value);
    const char* next = stop;
    while (next != end && is_blank(*next)) ++next;
    if (code == std::errc() && (next == end || *next == ',')) [[likely]] {
      if (!std::isinf(value)) return next;
    }
    return read_odd_field(at, end, column, value);
  }

  /// Everything that is no plain number: a number beyond the range of a double, a number cut with the file, or an
  /// error.
  const char* read_odd_field(const char* at, const char* end, std::size_t column, double& value) {
    const char* next = std::find(at, end, ',');
    const std::string_view field = trimmed({at, static_cast<std::size_t>(next - at)});
    const auto number = parse_number(field);
    value = number.value_or(kMissing);
    if (number && !std::isinf(*number)) return next;
    if (next == end && !lines_.terminated()) {
      value = kMissing;
      recording_.cut = true;
      return next;
    }
    throw InputError(
        place(lines_.number()) + ": column " + printable(recording_.names[column], 60),
        quoted(std::string(field.substr(0, 400))),
        number ? "a finite number, or nothing where it is missing" : "a number, or nothing where it is missing");
  }

  [[noreturn]] void refuse_surplus(std::string_view line) const {
    const auto fields = std::count(line.begin(), line.end(), ',') + 1;
    throw InputError(place(lines_.number()), fmt::format("{} fields", fields),
                     fmt::format("at most {}, one per column of the header", recording_.names.size()));
  }

  std::string name_;
  RecordingLimits limits_;
  std::uintmax_t bytes_;
  LineReader lines_;
  Recording recording_;
  std::vector<double*> cursors_;
  std::size_t rows_ = 0, capacity_ = 0, empty_lines_ = 0;
};

std::string header_field(const std::string& name) {
  if (name.find_first_of(",\"") == std::string::npos) return name;
  std::string out(1, '"');
  for (const char c : name) out.append(c == '"' ? 2 : 1, c);
  out += '"';
  return out;
}

}  // namespace

Recording read_csv(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  return CsvParser(file, name, limits, error ? 0 : bytes).parse();
}

void write_csv(const std::filesystem::path& file, const Recording& recording) {
  std::string text;
  for (std::size_t c = 0; c < recording.names.size(); ++c)
    text.append(c > 0 ? "," : "").append(header_field(recording.names[c]));
  text += '\n';
  char number[32];
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    for (std::size_t c = 0; c < recording.columns.size(); ++c) {
      if (c > 0) text += ',';
      const double value = recording.columns[c][row];
      // An empty field would do too, but a lone empty field would be an empty line.
      const auto end =
          std::isnan(value) ? std::copy_n("nan", 3, number) : std::to_chars(number, number + sizeof number, value).ptr;
      text.append(number, end);
    }
    text += '\n';
  }
  write_file_atomically(file, text);
}

}  // namespace lacuna
