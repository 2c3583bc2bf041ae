#include "scenarios/bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "scenarios/bag_sqlite.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/mcap.h"
#include "scenarios/text.h"
#include "scenarios/topic_table.h"
#include "scenarios/yaml_reader.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

const char* const kMetadata = "metadata.yaml";
constexpr std::size_t kMaxBagFiles = 10'000;

struct BagFiles {
  std::vector<fs::path> files;
  bool packed_messages = false;
};

std::string lower_extension(const fs::path& path) {
  std::string out = path.extension().string();
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string text_or_nothing(const YamlCursor& info, const char* key) {
  const auto cursor = info.find(key);
  return cursor && cursor->is_scalar() && !cursor->is_empty() ? cursor->text() : "";
}

/// Where a listed file lies: in the folder, or, as older recorders wrote it, below the folder's own name.
fs::path listed_file(const fs::path& folder, const YamlCursor& entry) {
  const fs::path written = entry.text();
  for (const fs::path& candidate : {folder / written, folder / written.filename()}) {
    std::error_code ignored;
    if (inside(folder, candidate) && fs::is_regular_file(candidate, ignored)) return candidate.lexically_normal();
  }
  entry.fail("a file in the bag's folder");
}

BagFiles files_of_folder(const fs::path& folder, const std::string& shown) {
  const fs::path metadata = folder / kMetadata;
  const std::string name = shown + "/" + kMetadata;
  std::error_code ignored;
  if (!fs::exists(metadata, ignored))
    throw InputError(printable(shown), "a folder without metadata.yaml",
                     "a bag of ROS 2 (ros2 bag reindex writes what is missing)");
  const YamlNode root = parse_yaml(read_text_file(metadata, name, "a bag's metadata", kYamlMaxBytes), name);
  const YamlCursor info = YamlCursor(root, name).at("rosbag2_bagfile_information");
  BagFiles out;
  const std::string mode = text_or_nothing(info, "compression_mode"),
                    format = text_or_nothing(info, "compression_format");
  const auto is = [&](const char* word) {
    return std::equal(mode.begin(), mode.end(), word, word + std::char_traits<char>::length(word),
                      [](unsigned char a, char b) { return std::tolower(a) == b; });
  };
  if (is("file"))
    throw InputError(
        name, "files compressed as a whole",
        "a bag unpacked by: ros2 bag convert, or zstd -d FILE and the names without .zstd in metadata.yaml");
  out.packed_messages = is("message");
  if (out.packed_messages && format != "zstd")
    throw InputError(name, "messages compressed by " + quoted(format), "zstd");
  for (const YamlCursor& entry : info.at("relative_file_paths").items()) {
    if (out.files.size() == kMaxBagFiles) entry.fail(fmt::format("at most {} files", kMaxBagFiles));
    out.files.push_back(listed_file(folder, entry));
  }
  if (out.files.empty()) throw InputError(name, "no files", "relative_file_paths to name some");
  return out;
}

}  // namespace

bool is_bag(const fs::path& path) {
  std::error_code ignored;
  const std::string extension = lower_extension(path);
  return extension == ".db3" || extension == ".mcap" || fs::is_directory(path, ignored);
}

std::vector<fs::path> recording_files(const fs::path& recording, const std::string& shown) {
  std::error_code ignored;
  if (!fs::is_directory(recording, ignored)) return {recording};
  std::vector<fs::path> out = files_of_folder(recording, shown).files;
  out.insert(out.begin(), recording / kMetadata);
  return out;
}

void copy_recording(const fs::path& source, const fs::path& target) {
  std::error_code error;
  const bool folder = fs::is_directory(source, error);
  for (const fs::path& file : recording_files(source, source.string())) {
    const fs::path to = folder ? target / fs::relative(file, source, error) : target;
    if (!fs::equivalent(file, to, error)) copy_file_atomically(file, to);
  }
}

TrackSet read_bag(const fs::path& path, const std::string& shown, const RecordingLimits& limits, bool log_times) {
  std::error_code ignored;
  const bool folder = fs::is_directory(path, ignored);
  const BagFiles bag = folder ? files_of_folder(path, shown) : BagFiles{{path}, false};
  TopicTable table(shown, limits, log_times);
  std::vector<std::string> notes;
  std::uintmax_t bytes = 0;
  for (const fs::path& file : bag.files) {
    const std::string name = folder ? shown + "/" + file.filename().string() : shown;
    bytes += check_regular_file(file, name, "a file of a bag", limits.bytes);
    if (bytes > limits.bytes)
      throw InputError(printable(shown), fmt::format("more than {} bytes", limits.bytes), "a smaller bag");
    if (lower_extension(file) == ".mcap")
      read_mcap(file, name, limits, table, notes);
    else if (lower_extension(file) == ".db3")
      read_bag_sqlite(file, name, limits, bag.packed_messages, table);
    else
      throw InputError(printable(name), "a file ending in " + quoted(file.extension().string()),
                       "a bag's file, .db3 or .mcap");
  }
  TrackSet out = table.take();
  out.notes.insert(out.notes.begin(), notes.begin(), notes.end());
  return out;
}

}  // namespace lacuna
