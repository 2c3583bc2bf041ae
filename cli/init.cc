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
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/mjcf.h"
#include "scenarios/text.h"
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
};

std::string relative_to(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path out = fs::relative(fs::weakly_canonical(file), fs::weakly_canonical(folder), error);
  return error || out.empty() ? fs::absolute(file).generic_string() : out.generic_string();
}

std::vector<Placed> place(const fs::path& folder, const std::vector<std::string>& recordings) {
  std::vector<Placed> out;
  std::set<std::string> taken;
  for (const std::string& file : recordings) {
    Placed one{file, "", !inside(folder, file)};
    one.name = one.copied ? one.source.filename().string() : relative_to(folder, file);
    const fs::path wanted = one.name;
    for (int again = 2; !taken.insert(one.name).second; ++again) {
      if (!one.copied) throw InputError("RECORDING", quoted(file) + " twice", "each recording once");
      one.name = fmt::format("{}_{}{}", wanted.stem().string(), again, wanted.extension().string());
    }
    out.push_back(one);
  }
  return out;
}

bool same_content(const fs::path& a, const fs::path& b) {
  std::error_code error;
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
  for (const Placed& one : placed) {
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
    for (const Placed& other : placed)
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
      for (double& t : scaled.columns[static_cast<std::size_t>(scaled.find(draft.time_column))]) t *= draft.time_scale;
      write_csv(folder / in_seconds(placed[i].name), scaled);
    } else if (placed[i].copied) {
      std::error_code error;
      fs::copy_file(placed[i].source, folder / placed[i].name, fs::copy_options::overwrite_existing, error);
      if (error) throw WorkError("cannot copy " + quoted(placed[i].source.string()) + ": " + error.message());
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
  const auto copied = std::count_if(placed.begin(), placed.end(), [](const Placed& one) { return one.copied; });
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
  for (const Placed& one : placed)
    request.recordings.push_back({one.name, load_recording(one.source, one.source.string())});
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
  command.add_option("RECORDING", options->recordings, "Its recordings, in the order in which they were made")
      ->required()
      ->option_text("... ");
  command.add_option("--name", options->name, "Name of the scenario (default: the robot's)");
  command.add_flag("--force", options->force,
                   "Replace a scenario.yaml, or copies of recordings, that are there already");
}

}  // namespace lacuna
