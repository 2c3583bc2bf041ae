#include "scenarios/recording.h"

#include <algorithm>
#include <cctype>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_formats.h"
#include "scenarios/text.h"

namespace lacuna {

int Recording::find(const std::string& name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

Recording read_recording(const std::filesystem::path& file, const std::string& name, const RecordingLimits& limits) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  check_regular_file(file, name, "a recording (.csv or .mat)", limits.bytes);
  if (extension == ".csv") return read_csv(file, name, limits);
  if (extension == ".mat") return read_mat(file, name, limits);
  throw InputError(printable(name), "a file ending in " + quoted(extension), "a recording ending in .csv or .mat");
}

std::shared_ptr<const Recording> load_recording(const std::filesystem::path& file, const std::string& shown_name,
                                                const RecordingLimits& limits) {
  return std::make_shared<const Recording>(read_recording(file, shown_name, limits));
}

}  // namespace lacuna
