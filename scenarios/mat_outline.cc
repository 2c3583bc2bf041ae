#include "scenarios/mat_outline.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <string_view>
#include <vector>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::size_t kHeaderBytes = 128;
constexpr int kMaxDepth = 8;
constexpr std::size_t kMaxRank = 8;
constexpr std::size_t kMaxFieldName = 256;
/// Of one compressed variable: 128 million numbers.
constexpr std::size_t kMaxInflated = std::size_t{1} << 30;
const char* const kExpected = "a MATLAB file of version 5, 7 or 7.3";

/// Element types of the format.
enum ElementType : std::uint32_t { kInt8 = 1, kInt32 = 5, kUint32 = 6, kMatrix = 14, kCompressed = 15 };
/// Array classes of the format.
enum ArrayClass : std::uint32_t { kCell = 1, kStruct = 2, kChar = 4, kDouble = 6, kUint64 = 15 };

/// Bytes of one value of a numeric or text element type; 0 for the others.
std::size_t value_bytes(std::uint32_t type) {
  static constexpr std::uint8_t kBytes[19] = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8, 0, 0, 1, 2, 4};
  return type < std::size(kBytes) ? kBytes[type] : 0;
}

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

/// Walks the elements of a stretch of bytes.
class Walker {
 public:
  Walker(std::string_view bytes, bool big_endian, std::string where)
      : rest_(bytes), big_endian_(big_endian), where_(std::move(where)) {}

  bool at_end() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }
  Walker within(std::string_view bytes) const { return {bytes, big_endian_, where_}; }

  std::uint32_t number(std::string_view bytes, std::size_t index = 0) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value |= std::uint32_t{static_cast<unsigned char>(bytes[4 * index + (big_endian_ ? 3 - i : i)])} << (8 * i);
    return value;
  }

  /// The next element. `padded`: filled up to eight bytes, as inside a matrix; small ones carry their data in the tag.
  Element next(bool padded) {
    if (rest_.size() < 8) refuse("an element cut short");
    const std::uint32_t first = number(rest_);
    if (padded && first >> 16 != 0) {
      const std::size_t bytes = first >> 16;
      if (bytes > 4) refuse("a small element of more than 4 bytes");
      const Element small{first & 0xFFFF, rest_.substr(4, bytes)};
      rest_.remove_prefix(8);
      return small;
    }
    const std::size_t bytes = number(rest_, 1);
    if (bytes > rest_.size() - 8)
      refuse(fmt::format("an element of {} bytes where {} are left", bytes, rest_.size() - 8));
    const Element element{first, rest_.substr(8, bytes)};
    const std::size_t filled = padded && first != kMatrix ? (bytes + 7) / 8 * 8 : bytes;
    rest_.remove_prefix(std::min(8 + filled, rest_.size()));
    return element;
  }

  Element next_of(std::uint32_t type, const char* what) {
    const Element element = next(true);
    if (element.type != type) refuse(fmt::format("an element of type {} for {}", element.type, what));
    return element;
  }

  [[noreturn]] void refuse(const std::string& found, const char* expected = "an intact MATLAB file") const {
    throw InputError(where_, found, expected);
  }

 private:
  std::string_view rest_;
  bool big_endian_;
  std::string where_;
};

std::size_t check_dimensions(Walker& walker) {
  const Element dimensions = walker.next_of(kInt32, "dimensions");
  const std::size_t rank = dimensions.data.size() / 4;
  if (rank < 2 || rank > kMaxRank || dimensions.data.size() % 4 != 0)
    walker.refuse(fmt::format("an array of rank {}", rank));
  std::size_t count = 1;
  for (std::size_t d = 0; d < rank; ++d) {
    const std::uint32_t size = walker.number(dimensions.data, d);
    if (size > 0x7FFFFFFF || __builtin_mul_overflow(count, std::size_t{size}, &count))
      walker.refuse("impossible dimensions");
  }
  return count;
}

void check_values(Walker& walker, std::size_t count) {
  const Element values = walker.next(true);
  const std::size_t bytes = value_bytes(values.type);
  if (bytes == 0) walker.refuse(fmt::format("values of type {}", values.type));
  if (values.data.size() % bytes != 0 || values.data.size() / bytes != count)
    walker.refuse(fmt::format("{} bytes for {} values", values.data.size(), count));
}

void check_matrix(Walker walker, int depth);

/// `count` matrices, one after the other: a cell's, or the fields of structs.
void check_members(Walker& walker, std::size_t count, int depth) {
  if (count > walker.left() / 8) walker.refuse(fmt::format("{} members in {} bytes", count, walker.left()));
  for (std::size_t i = 0; i < count; ++i) {
    const Element member = walker.next_of(kMatrix, "a member");
    if (!member.data.empty()) check_matrix(walker.within(member.data), depth + 1);
  }
}

void check_struct(Walker& walker, std::size_t count, int depth) {
  const Element length = walker.next_of(kInt32, "the length of field names");
  const std::size_t name_bytes = length.data.size() == 4 ? walker.number(length.data) : 0;
  if (name_bytes == 0 || name_bytes > kMaxFieldName) walker.refuse("an impossible length of field names");
  const Element names = walker.next_of(kInt8, "field names");
  if (names.data.size() % name_bytes != 0) walker.refuse("field names that do not fill their length");
  const std::size_t fields = names.data.size() / name_bytes;
  for (std::size_t f = 0; f < fields; ++f)
    if (names.data.substr(f * name_bytes, name_bytes).find('\0') == std::string_view::npos)
      walker.refuse("a field name without an end");
  std::size_t members = 0;
  if (__builtin_mul_overflow(count, fields, &members)) walker.refuse("impossible dimensions");
  check_members(walker, members, depth);
}

/// The inside of one matrix element: flags, dimensions, name, and what its class holds.
void check_matrix(Walker walker, int depth) {
  if (depth > kMaxDepth) walker.refuse(fmt::format("more than {} levels of nesting", kMaxDepth));
  const Element flags = walker.next_of(kUint32, "flags");
  if (flags.data.size() != 8) walker.refuse("broken flags");
  const std::uint32_t array_class = walker.number(flags.data) & 0xFF;
  const bool complex = (walker.number(flags.data) & 0x0800) != 0;
  const std::size_t count = check_dimensions(walker);
  const Element name = walker.next_of(kInt8, "a name");
  if (name.data.size() > kMaxFieldName) walker.refuse("a name of more than 256 bytes");
  if (array_class == kCell) {
    check_members(walker, count, depth);
  } else if (array_class == kStruct) {
    check_struct(walker, count, depth);
  } else if (array_class == kChar || (array_class >= kDouble && array_class <= kUint64)) {
    check_values(walker, count);
    if (complex) check_values(walker, count);
  } else {
    walker.refuse(fmt::format("the variable {} of array class {}", quoted(std::string(name.data), 60), array_class),
                  "numeric vectors, or one struct of them");
  }
  if (!walker.at_end()) walker.refuse(fmt::format("{} bytes beyond the end of a variable", walker.left()));
}

/// The bytes of a compressed variable.
std::string inflated(std::string_view data, const Walker& walker) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw WorkError("zlib cannot start");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, &inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  std::string out;
  int state = Z_OK;
  while (state == Z_OK) {
    const std::size_t done = out.size();
    if (done >= kMaxInflated) walker.refuse(fmt::format("a variable of more than {} bytes", kMaxInflated));
    out.resize(std::max<std::size_t>(2 * done, 4096));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    stream.avail_out = static_cast<uInt>(out.size() - done);
    state = inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
  }
  if (state != Z_STREAM_END) walker.refuse("a compressed variable that does not inflate");
  return out;
}

void check_variable(const Element& element, const Walker& walker) {
  if (element.type == kMatrix) {
    check_matrix(walker.within(element.data), 0);
    return;
  }
  if (element.type != kCompressed) walker.refuse(fmt::format("an element of type {}", element.type));
  const std::string plain = inflated(element.data, walker);
  Walker inner = walker.within(plain);
  const Element matrix = inner.next(false);
  if (matrix.type != kMatrix || !inner.at_end()) walker.refuse("a compressed element that is no variable");
  check_matrix(walker.within(matrix.data), 0);
}

}  // namespace

MatForm check_mat_outline(const std::filesystem::path& file, const std::string& name) {
  const std::string where = printable(name);
  std::string text(kHeaderBytes, '\0');
  std::ifstream head(file, std::ios::binary);
  head.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (static_cast<std::size_t>(head.gcount()) < kHeaderBytes)
    throw InputError(where, fmt::format("{} bytes", head.gcount()), kExpected);
  const bool big_endian = text[126] == 'M' && text[127] == 'I';
  if (!big_endian && !(text[126] == 'I' && text[127] == 'M')) throw InputError(where, "no MATLAB 5 header", kExpected);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const int version = big_endian ? byte(124) << 8 | byte(125) : byte(125) << 8 | byte(124);
  if (version == 0x0200) return MatForm::hdf5;
  if (version != 0x0100) throw InputError(where, fmt::format("format version 0x{:04x}", version), kExpected);
  text = read_text_file(file, name, kExpected, std::filesystem::file_size(file));
  Walker walker(std::string_view(text).substr(kHeaderBytes), big_endian, where);
  while (!walker.at_end()) {
    const Element element = walker.next(false);
    check_variable(element, walker);
  }
  return MatForm::five;
}

}  // namespace lacuna
