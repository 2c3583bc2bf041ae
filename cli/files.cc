#include "cli/files.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>

#include "cli/command.h"
#include "scenarios/bag.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_check.h"
#include "scenarios/scenario_parser.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

/// FNV-1a, 64 bits: tells changed files from unchanged ones; not meant against forgery.
class Hash {
 public:
  void add(const char* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ static_cast<unsigned char>(data[i])) * 0x100000001b3U;
  }
  /// Separators keep ("ab", "c") and ("a", "bc") apart.
  void add(const std::string& text) { add(text.c_str(), text.size() + 1); }

  void add_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string(), "a file that cannot be read", "the file that was just loaded");
    std::vector<char> block(std::size_t{1} << 20);
    std::uint64_t size = 0;
    while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0) {
      add(block.data(), static_cast<std::size_t>(in.gcount()));
      size += static_cast<std::uint64_t>(in.gcount());
    }
    add(std::to_string(size));
  }

  std::string str() const { return fmt::format("{:016x}", value_); }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

/// Path of a recording within the scenario's folder tree, whatever way it was written.
fs::path inner_path(const Scenario& scenario, const std::string& written) {
  const fs::path folder = scenario.folder().empty() ? fs::path(".") : scenario.folder();
  std::error_code error;
  const fs::path out =
      fs::relative(fs::weakly_canonical(resolve(scenario, written)), fs::weakly_canonical(folder), error);
  return error || out.empty() || *out.begin() == ".." ? resolve(scenario, written).filename() : out;
}

void copy_in(const fs::path& source, const fs::path& target) {
  std::error_code error;
  if (fs::equivalent(source, target, error)) return;
  make_parent_folder(target);
  copy_recording(source, target);
}

/// Name of the identified robot's file: never the one that was read.
std::string robot_name(const fs::path& folder, const Scenario& source) {
  const fs::path read = resolve(source, source.robot_file);
  std::string stem = read.stem().string();
  if (const std::string end = ".identified"; stem.size() > end.size() && stem.ends_with(end))
    stem.resize(stem.size() - end.size());
  std::string name = stem + ".identified.urdf";
  std::error_code ignored;
  if (fs::equivalent(read, folder / name, ignored)) name = read.stem().string() + ".identified.urdf";
  return name;
}

}  // namespace

std::vector<std::string> write_model_files(const fs::path& folder, const std::string& yaml_name, const Scenario& source,
                                           Scenario scenario, std::span<const double> link_masses) {
  refuse_overwriting(source.file, folder / yaml_name);
  std::map<std::string, std::string> moved;
  const auto bring = [&](std::string& file) {
    const std::string inner = inner_path(source, file).generic_string();
    if (moved.emplace(file, inner).second) copy_in(resolve(source, file), folder / inner);
    file = inner;
  };
  for (RecordingSpec& spec : scenario.recordings) {
    bring(spec.file);
    for (RecordingPart& part : spec.with) bring(part.file);
  }
  for (EffectSpec& effect : scenario.effects) {
    for (std::string& file : effect.recordings) {
      if (const auto at = moved.find(file); at != moved.end()) file = at->second;
    }
  }
  const std::string robot = robot_name(folder, source);
  write_file_atomically(folder / robot, to_urdf(*scenario.robot, link_masses));
  scenario.file = folder / yaml_name;
  scenario.robot_file = robot;
  save_scenario(scenario, scenario.file);
  return {yaml_name, robot};
}

std::string fingerprint(const Scenario& scenario, const std::vector<std::string>& words) {
  Hash hash;
  hash.add_file(scenario.file);
  hash.add_file(resolve(scenario, scenario.robot_file));
  std::set<std::string> seen;
  for (const RecordingSpec& spec : scenario.recordings)
    for (const auto& [path, part] : parts_of(scenario, spec)) {
      if (!seen.insert(part.file).second) continue;
      hash.add(part.file);
      for (const fs::path& file : recording_files(path, part.file)) hash.add_file(file);
    }
  std::string out = fmt::format("lacuna {} data {}", version(), hash.str());
  for (const std::string& word : words) out += " " + word;
  return out;
}

}  // namespace lacuna
