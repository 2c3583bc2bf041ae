// Recordings as MATLAB .mat through matio: version 5 (v6) and its compressed form (v7), and 7.3 as far as matio goes.
#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>

#include "scenarios/apart.h"
#include "scenarios/error.h"
#include "scenarios/mat_outline.h"
#include "scenarios/recording_formats.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using MatFile = std::unique_ptr<mat_t, int (*)(mat_t*)>;
using MatVariable = std::unique_ptr<matvar_t, void (*)(matvar_t*)>;

/// Deflate cannot shrink data by more than this: what claims to be larger is a lie about its size.
constexpr std::uintmax_t kMaxDeflateRatio = 1032;

void ignore_log(int, char*) {}

bool is_numeric(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT64;
}

/// Number of elements, or nothing where the dimensions overflow.
std::optional<std::uintmax_t> element_count(const matvar_t& variable) {
  if (variable.rank < 2 || variable.dims == nullptr) return std::nullopt;
  std::uintmax_t count = 1;
  for (int d = 0; d < variable.rank; ++d)
    if (__builtin_mul_overflow(count, std::uintmax_t{variable.dims[d]}, &count)) return std::nullopt;
  return count;
}

template <typename T>
void append_as(const matvar_t& variable, std::vector<double>& out) {
  const T* data = static_cast<const T*>(variable.data);
  out.assign(data, data + variable.nbytes / sizeof(T));
}

bool copy_values(const matvar_t& variable, std::vector<double>& out) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE: append_as<double>(variable, out); return true;
    case MAT_C_SINGLE: append_as<float>(variable, out); return true;
    case MAT_C_INT8: append_as<std::int8_t>(variable, out); return true;
    case MAT_C_UINT8: append_as<std::uint8_t>(variable, out); return true;
    case MAT_C_INT16: append_as<std::int16_t>(variable, out); return true;
    case MAT_C_UINT16: append_as<std::uint16_t>(variable, out); return true;
    case MAT_C_INT32: append_as<std::int32_t>(variable, out); return true;
    case MAT_C_UINT32: append_as<std::uint32_t>(variable, out); return true;
    case MAT_C_INT64: append_as<std::int64_t>(variable, out); return true;
    case MAT_C_UINT64: append_as<std::uint64_t>(variable, out); return true;
    default: return false;
  }
}

class MatReader {
 public:
  MatReader(const std::filesystem::path& file, std::string name, const RecordingLimits& limits)
      : name_(std::move(name)),
        limits_(limits),
        bytes_(std::filesystem::file_size(file)),
        mat_(Mat_Open(file.c_str(), MAT_ACC_RDONLY), &Mat_Close) {
    if (!mat_) refuse("", "no readable MATLAB file", "version 5, 7 or 7.3 (save -v7)");
  }

  Recording read() {
    while (true) {
      MatVariable variable(Mat_VarReadNextInfo(mat_.get()), &Mat_VarFree);
      if (!variable) break;
      take(*variable);
    }
    if (columns_.empty()) refuse("", "no numeric vectors", "one vector per column, or one struct of vectors");
    return finish();
  }

 private:
  struct Column {
    std::string name;
    std::vector<double> values;
  };

  [[noreturn]] void refuse(const std::string& what, const std::string& found, const std::string& expected) const {
    throw InputError(printable(name_) + (what.empty() ? "" : ": " + printable(what, 80)), found, expected);
  }

  std::string name_of(const matvar_t& variable) const { return variable.name == nullptr ? "" : variable.name; }

  void take(matvar_t& variable) {
    const std::string name = name_of(variable);
    if (variable.class_type == MAT_C_STRUCT) {
      take_struct(variable, name);
    } else if (is_numeric(variable)) {
      check_vector(variable, name);
      if (Mat_VarReadDataAll(mat_.get(), &variable) != 0) refuse(name, "data that cannot be read", "numbers");
      add(variable, name);
    }
    // Text, cells and functions are notes of the user's, not columns.
  }

  void take_struct(matvar_t& variable, const std::string& name) {
    if (element_count(variable) != 1u) refuse(name, "an array of structs", "one struct of vectors");
    if (struct_seen_) refuse(name, "a second struct", "one struct of vectors");
    struct_seen_ = true;
    const unsigned count = Mat_VarGetNumberOfFields(&variable);
    char* const* names = Mat_VarGetStructFieldnames(&variable);
    if (count == 0 || names == nullptr) refuse(name, "a struct without fields", "a struct of vectors");
    if (count > limits_.columns)
      refuse(name, fmt::format("{} fields", count), fmt::format("at most {}", limits_.columns));
    for (unsigned i = 0; i < count; ++i) {
      const matvar_t* field = Mat_VarGetStructFieldByIndex(&variable, i, 0);
      if (field != nullptr && is_numeric(*field)) check_vector(*field, name + "." + names[i]);
      // Nested structs and cells would be read along without a check of their size.
      if (field != nullptr && (field->class_type == MAT_C_STRUCT || field->class_type == MAT_C_CELL))
        refuse(name + "." + names[i], "a struct or cell", "a vector");
    }
    if (Mat_VarReadDataAll(mat_.get(), &variable) != 0) refuse(name, "data that cannot be read", "numbers");
    for (unsigned i = 0; i < count; ++i) {
      const matvar_t* field = Mat_VarGetStructFieldByIndex(&variable, i, 0);
      if (field != nullptr && is_numeric(*field)) add(*field, names[i]);
    }
  }

  void check_vector(const matvar_t& variable, const std::string& name) const {
    const auto count = element_count(variable);
    if (!count) refuse(name, "impossible dimensions", "a vector");
    if (variable.isComplex != 0) refuse(name, "complex numbers", "real numbers");
    const bool is_vector = variable.rank == 2 && (variable.dims[0] == 1 || variable.dims[1] == 1);
    if (!is_vector && *count > 0)
      refuse(
          name,
          fmt::format("an array of {} x {}{}", variable.dims[0], variable.dims[1], variable.rank > 2 ? " x ..." : ""),
          "a vector");
    if (*count > limits_.bytes / 8 || *count > kMaxDeflateRatio * bytes_)
      refuse(name, fmt::format("{} values in a file of {} bytes", *count, bytes_), "a size that the file can hold");
  }

  void add(const matvar_t& variable, const std::string& name) {
    const auto count = element_count(variable);
    if (count == 0u) refuse(name, "an empty vector", "numbers");
    const std::uintmax_t size = variable.data_size > 0 ? static_cast<std::uintmax_t>(variable.data_size) : 0;
    Column column{name, {}};
    if (!count || variable.data == nullptr || variable.nbytes != *count * size ||
        !copy_values(variable, column.values) || column.values.size() != *count)
      refuse(name, "data that does not fill its dimensions", "a vector of numbers");
    if (columns_.size() == limits_.columns) refuse(name, "one column more", fmt::format("at most {}", limits_.columns));
    columns_.push_back(std::move(column));
  }

  Recording finish() {
    // Single numbers beside vectors (a sampling rate, a temperature) are notes too.
    std::size_t rows = 0;
    for (const Column& column : columns_) rows = std::max(rows, column.values.size());
    if (rows > 1) std::erase_if(columns_, [](const Column& column) { return column.values.size() == 1; });
    Recording out;
    out.file = name_;
    for (Column& column : columns_) {
      if (column.values.size() != rows)
        refuse(column.name, fmt::format("{} values", column.values.size()),
               fmt::format("{}, as in the longest column", rows));
      if (find_invalid_utf8(column.name) != std::string::npos || column.name.empty())
        refuse(column.name, "an unusable name", "a column name");
      if (out.find(column.name) >= 0) refuse(column.name, "the column twice", "each column name once");
      for (std::size_t row = 0; row < rows; ++row) {
        if (std::isinf(column.values[row]))
          refuse(column.name, fmt::format("an infinite value at {}", row + 1), "finite values");
        if (std::isnan(column.values[row])) ++out.missing;
      }
      out.names.push_back(std::move(column.name));
      out.columns.push_back(std::move(column.values));
    }
    return out;
  }

  std::string name_;
  RecordingLimits limits_;
  std::uintmax_t bytes_;
  MatFile mat_;
  bool struct_seen_ = false;
  std::vector<Column> columns_;
};

/// A reading of version 7.3 may take so long (s), and a second more for so many bytes.
constexpr double kFreeSeconds = 15.0, kBytesASecond = 4e6;

/// Numbers and texts one after the other, between two processes of one program.
class Parcel {
 public:
  explicit Parcel(std::string bytes = {}) : bytes_(std::move(bytes)) {}

  void put(std::uint64_t x) { bytes_.append(reinterpret_cast<const char*>(&x), sizeof x); }
  void put(std::string_view x) {
    put(std::uint64_t{x.size()});
    bytes_.append(x);
  }
  void put(const std::vector<double>& x) {
    put(std::string_view(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double)));
  }

  std::uint64_t number() {
    std::uint64_t out = 0;
    std::memcpy(&out, take(sizeof out).data(), sizeof out);
    return out;
  }
  std::string_view text() { return take(number()); }
  std::vector<double> numbers() {
    const std::string_view raw = text();
    std::vector<double> out(raw.size() / sizeof(double));
    std::memcpy(out.data(), raw.data(), out.size() * sizeof(double));
    return out;
  }
  std::string bytes() && { return std::move(bytes_); }

 private:
  std::string_view take(std::uint64_t bytes) {
    if (bytes > bytes_.size() - at_) throw WorkError("a broken message between two processes");
    const std::string_view out = std::string_view(bytes_).substr(at_, bytes);
    at_ += bytes;
    return out;
  }

  std::string bytes_;
  std::size_t at_ = 0;
};

/// What the other process makes of the file: 0 and its columns, or 1 and a refusal.
std::string packed_reading(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  Parcel out;
  try {
    const Recording data = MatReader(file, name, limits).read();
    out.put(std::uint64_t{0});
    out.put(std::uint64_t{data.missing});
    out.put(std::uint64_t{data.names.size()});
    for (std::size_t c = 0; c < data.names.size(); ++c) out.put(data.names[c]), out.put(data.columns[c]);
  } catch (const InputError& error) {
    out = Parcel();
    out.put(std::uint64_t{1});
    out.put(std::string_view(error.what()));
  } catch (const std::exception&) {  // no memory
    out = Parcel();
    out.put(std::uint64_t{1});
    out.put(std::string_view(printable(name) + ": found more than memory holds, expected a smaller file"));
  }
  return std::move(out).bytes();
}

/// The same error again, from its text.
[[noreturn]] void rethrow(std::string_view what) {
  constexpr std::string_view kFound = ": found ", kInstead = ", expected ";
  const std::size_t found = std::min(what.find(kFound), what.size());
  const std::size_t instead = what.find(kInstead, found);
  if (instead == std::string_view::npos) throw InputError(std::string(what), "an error", "none");
  const std::size_t begin = found + kFound.size();
  throw InputError(std::string(what.substr(0, found)), std::string(what.substr(begin, instead - begin)),
                   std::string(what.substr(instead + kInstead.size())));
}

/// HDF5 believes what a file says of itself, and no outline of it is checked here: a process of its own reads it.
Recording read_hdf5(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  const auto bytes = static_cast<double>(std::filesystem::file_size(file));
  ApartLimits apart;
  apart.seconds = kFreeSeconds + bytes / kBytesASecond;
  apart.memory = 3 * limits.bytes, apart.result = limits.bytes;
  ApartOutcome outcome = run_apart([&] { return packed_reading(file, name, limits); }, apart);
  if (!outcome.done)
    throw InputError(printable(name), "a MATLAB 7.3 file that the HDF5 library cannot read (" + outcome.failure + ")",
                     "an intact one (or save -v7)");
  Parcel parcel(std::move(outcome.result));
  if (parcel.number() != 0) rethrow(parcel.text());
  Recording out;
  out.file = name;
  out.missing = parcel.number();
  for (std::uint64_t columns = parcel.number(); columns > 0; --columns) {
    out.names.emplace_back(parcel.text());
    out.columns.push_back(parcel.numbers());
  }
  return out;
}

}  // namespace

Recording read_mat(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  const MatForm form = check_mat_outline(file, name);
  // matio's log function is one per process.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  Mat_LogInitFunc("lacuna", &ignore_log);
  if (form == MatForm::hdf5) return read_hdf5(file, name, limits);
  return MatReader(file, name, limits).read();
}

}  // namespace lacuna
