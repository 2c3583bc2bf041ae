// `lacuna init`: a first scenario.yaml from a robot and its recordings.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/command.h"
#include "physics/plant_model.h"
#include "reports/json_text.h"
#include "scenarios/bag.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/mjcf.h"
#include "scenarios/recording_formats.h"
#include "scenarios/text.h"
#include "draft/columns.h"
#include "draft/draft.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct InitOptions {
  std::string robot, name;
  std::vector<std::string> recordings;
  bool force = false;
};

/// A recording's place in the folder: where it lies already, else a copy under its own name.
struct Placed {
  fs::path source;
  std::string name;  ///< as the scenario writes it
  bool copied = false;
  std::vector<Placed> with = {};  ///< files joined to it
};

std::string relative_to(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path out = fs::relative(fs::weakly_canonical(file), fs::weakly_canonical(folder), error);
  return error || out.empty() ? fs::absolute(file).generic_string() : out.generic_string();
}

/// "bag+valves.csv": files of one motion. A file that has a + in its name is that file.
std::vector<std::string> joined_files(const std::string& word) {
  std::error_code ignored;
  std::vector<std::string> out;
  if (fs::exists(word, ignored)) return {word};
  for (std::size_t begin = 0; begin <= word.size();) {
    const std::size_t end = std::min(word.find('+', begin), word.size());
    out.push_back(word.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

class Placer {
 public:
  explicit Placer(const fs::path& folder) : folder_(folder) {}

  /// A word of the command line: a recording, or several files joined by +.
  Placed word(const std::string& text) {
    const std::vector<std::string> files = joined_files(text);
    Placed out = file(files.front());
    for (std::size_t i = 1; i < files.size(); ++i) out.with.push_back(file(files[i]));
    return out;
  }

 private:
  Placed file(const std::string& written) {
    Placed one{written, "", !inside(folder_, written)};
    if (one.source.filename().empty()) one.source = one.source.parent_path();  // a bag's folder as "run/"
    one.name = one.copied ? one.source.filename().string() : relative_to(folder_, one.source);
    const fs::path wanted = one.name;
    for (int again = 2; !taken_.insert(one.name).second; ++again) {
      if (!one.copied) throw InputError("RECORDING", quoted(written) + " twice", "each recording once");
      one.name = fmt::format("{}_{}{}", wanted.stem().string(), again, wanted.extension().string());
    }
    return one;
  }

  fs::path folder_;
  std::set<std::string> taken_;
};

std::vector<Placed> place(const fs::path& folder, const std::vector<std::string>& recordings) {
  std::vector<Placed> out;
  Placer placer(folder);
  for (const std::string& word : recordings) out.push_back(placer.word(word));
  return out;
}

/// A recording and the files joined to it.
std::vector<Placed> all_files(const std::vector<Placed>& placed) {
  std::vector<Placed> out;
  for (const Placed& one : placed) {
    out.push_back(one);
    out.insert(out.end(), one.with.begin(), one.with.end());
  }
  return out;
}

/// Every topic and file on one clock, as the scenario to be written will use its columns.
DraftRecording read_placed(const Placed& one, const Robot& robot) {
  RecordingPart first;
  first.file = one.source.string();
  std::vector<std::pair<fs::path, RecordingPart>> parts{{one.source, first}};
  DraftRecording out{one.name, nullptr, {}};
  for (const Placed& more : one.with) {
    RecordingPart part;
    part.file = more.source.string();
    parts.emplace_back(more.source, part);
    part.file = more.name;
    out.with.push_back(part);
  }
  Recording data = read_recording(parts, {}, {});
  if (data.joined) data = read_recording(parts, {}, use_of(match_columns(robot, data.names)));
  out.data = std::make_shared<const Recording>(std::move(data));
  return out;
}

bool same_content(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::is_directory(a, error) || fs::is_directory(b, error)) return false;
  if (fs::file_size(a, error) != fs::file_size(b, error) || error) return false;
  std::ifstream one(a, std::ios::binary), other(b, std::ios::binary);
  return std::equal(std::istreambuf_iterator<char>(one), {}, std::istreambuf_iterator<char>(other));
}

/// Before anything is written: what is there already stays unless told otherwise.
void refuse_to_overwrite(const fs::path& folder, const fs::path& scenario, const std::vector<Placed>& placed) {
  std::error_code ignored;
  if (fs::exists(scenario, ignored))
    throw InputError(scenario.string(), "a scenario that is there already",
                     "another folder (-o DIR), or --force to replace it");
  for (const Placed& one : all_files(placed)) {
    const fs::path target = folder / one.name;
    if (one.copied && fs::exists(target, ignored) && !same_content(one.source, target))
      throw InputError(target.string(), "another file of this name",
                       "another folder (-o DIR), or --force to replace it");
  }
}

/// The same of the recordings that are written once more with another clock; and never one of those given.
void refuse_to_replace_scaled(const fs::path& folder, const std::vector<Placed>& placed, bool force) {
  std::set<std::string> targets;
  std::error_code ignored;
  for (const Placed& one : placed) {
    const fs::path target = folder / in_seconds(one.name);
    if (!targets.insert(target.string()).second)
      throw InputError(target.string(), "two recordings that would both be written there",
                       "names that differ before the extension");
    for (const Placed& other : all_files(placed))
      if (fs::equivalent(target, other.source, ignored))
        throw InputError(target.string(), "a recording that would be replaced", "another name");
    if (!force && fs::exists(target, ignored))
      throw InputError(target.string(), "a file that is there already",
                       "another folder (-o DIR), or --force to replace it");
  }
}

/// Into the folder what lies elsewhere; where the clock is not in s, everything once more with a clock that is.
void bring_recordings(const fs::path& folder, const std::vector<Placed>& placed, const DraftRequest& request,
                      const Draft& draft) {
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (draft.time_scale != 1.0) {
      Recording scaled = *request.recordings[i].data;
      for (double& t : scaled.columns[scaled.find(draft.time_column)]) t *= draft.time_scale;
      write_csv(folder / in_seconds(placed[i].name), scaled);
    } else {
      for (const Placed& one : all_files({placed[i]}))
        if (one.copied) copy_recording(one.source, folder / one.name);
    }
  }
}

/// What was written is read as any other command will read it.
void check_written(const fs::path& file) {
  const Scenario scenario = load_scenario(file);
  log_notes(scenario.notes);
  const PlantModel model(scenario);
}

std::string summary(const fs::path& file, const Draft& draft, const std::vector<Placed>& placed) {
  const std::vector<Placed> files = all_files(placed);
  const auto copied = std::count_if(files.begin(), files.end(), [](const Placed& one) { return one.copied; });
  std::string out = fmt::format("{}: {} recording{}", file.string(), placed.size(), placed.size() == 1 ? "" : "s");
  if (copied > 0) out += fmt::format(", {} copied beside it", copied);
  out += fmt::format("; {} guesses, each with its reason in a comment\n", draft.guesses.size());
  if (!draft.questions.empty()) out += "Only you know, or please check:\n";
  for (const std::string& question : draft.questions) out += "  - " + question + "\n";
  return out + fmt::format("Then: lacuna diagnose {}\n", file.string());
}

void run(const Session& session, const InitOptions& options) {
  const fs::path robot_file = options.robot;
  const auto robot = read_robot_file(robot_file).robot;
  const std::string name = options.name.empty() ? robot->name() : options.name;
  const fs::path folder = session.output.empty() ? fs::path("out") / file_name(name) : fs::path(session.output);
  const fs::path file = folder / "scenario.yaml";
  const std::vector<Placed> placed = place(folder, options.recordings);
  if (!options.force) refuse_to_overwrite(folder, file, placed);

  DraftRequest request{name, relative_to(folder, robot_file), robot, {}};
  for (const Placed& one : placed) request.recordings.push_back(read_placed(one, *robot));
  const Draft draft = draft_scenario(request);
  if (draft.time_scale != 1.0) refuse_to_replace_scaled(folder, placed, options.force);
  make_parent_folder(file);
  bring_recordings(folder, placed, request, draft);
  write_file_atomically(file, draft.yaml);
  if (session.json) {
    print(json_text({{"format", "lacuna-init/1"},
                     {"version", version()},
                     {"scenario", file.string()},
                     {"guesses", draft.guesses},
                     {"questions", draft.questions}}));
  } else {
    print(summary(file, draft, placed));
  }
  check_written(file);
}

}  // namespace

void add_init(CLI::App& app, Session& session) {
  auto options = std::make_shared<InitOptions>();
  CLI::App& command = add_command(
      app, session, "init",
      "A first scenario.yaml from a robot and its recordings: columns matched to joints, units, clock and start values "
      "read off the numbers, roles dealt out; every guess has its reason in a comment, what is missing is asked for.\n"
      "Written to DIR/scenario.yaml (-o DIR, else out/<name>). Recordings below DIR stay where they are, others are "
      "copied into it; the robot's file stays where it is",
      "lacuna init my_arm.urdf run_1.csv run_2.csv run_3.csv -o my_arm",
      [&session, options] { run(session, *options); });
  command.add_option("ROBOT", options->robot, "The robot's file (URDF or MJCF)")->required()->option_text(" ");
  command
      .add_option("RECORDING", options->recordings,
                  "Its recordings (.csv, .mat, .db3, .mcap, a bag's folder), in the order in which they were made; "
                  "files of one motion joined by +")
      ->required()
      ->option_text("... ");
  command.add_option("--name", options->name, "Name of the scenario (default: the robot's)");
  command.add_flag("--force", options->force,
                   "Replace a scenario.yaml, or copies of recordings, that are there already");
}

}  // namespace lacuna
