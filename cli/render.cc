// `lacuna render`: the robot drawn in given or recorded poses, by every engine's own link poses.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "render/snapshot.h"
#include "reports/json_text.h"
#include "scenarios/error.h"
#include "scenarios/recording_choice.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct RenderOptions {
  std::string engine = "featherstone", recording, times;
  std::vector<std::string> poses, package_paths;
  PoseOptions picture;
};

std::vector<double> numbers(const std::string& text, const std::string& option) {
  std::vector<double> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto value = parse_number(text.substr(begin, end - begin));
    if (!value || !std::isfinite(*value))
      throw InputError(option, quoted(text.substr(begin, end - begin)), "finite numbers with commas between them");
    out.push_back(*value);
    begin = end + 1;
  }
  return out;
}

Pose given_pose(const Scenario& scenario, const std::string& text) {
  Pose out{numbers(text, "--pose"), "q = " + printable(text, 100)};
  const std::size_t dof = scenario.robot->dof();
  if (out.q.size() != dof) {
    std::string names;
    for (const Joint& joint : scenario.robot->joints()) names += (names.empty() ? "" : ", ") + joint.name;
    throw InputError("--pose " + printable(text, 80), fmt::format("{} numbers", out.q.size()),
                     fmt::format("{}, one a joint: {}", dof, printable(names)));
  }
  return out;
}

std::vector<Pose> recorded_poses(const Scenario& scenario, const RenderOptions& options) {
  std::string name = options.recording;
  if (name.empty() && scenario.recordings.empty()) throw InputError("--time", "no recording", "--recording FILE");
  if (name.empty()) name = scenario.recordings.front().file;
  const Scenario one = with_recording(scenario, recording_named(scenario, name));
  if (one.channels.of.count(ChannelKind::position) == 0 || one.channels.of.at(ChannelKind::position).empty())
    throw InputError(scenario.file.string() + ": channels", "no position", "a measured position of at least one joint");
  if (options.times.empty()) throw InputError("--recording", "no --time", "the times to draw: --time 0.5,2");
  std::vector<Pose> out;
  for (const double time : numbers(options.times, "--time")) out.push_back(pose_at(one, one.recordings.front(), time));
  return out;
}

std::vector<Pose> poses_of(const Scenario& scenario, const RenderOptions& options) {
  std::vector<Pose> out;
  for (const std::string& text : options.poses) out.push_back(given_pose(scenario, text));
  if (!options.recording.empty() || !options.times.empty()) {
    const std::vector<Pose> recorded = recorded_poses(scenario, options);
    out.insert(out.end(), recorded.begin(), recorded.end());
  }
  if (out.empty())
    out.push_back({std::vector<double>(static_cast<std::size_t>(scenario.robot->dof()), 0.0), "all joints at 0"});
  return out;
}

/// All pictures in one; nothing where that would be larger than a picture may be.
void write_sheet(const fs::path& file, const std::vector<Snapshot>& snapshots, std::size_t engines,
                 std::vector<std::string>& written) {
  if (snapshots.size() < 2) return;
  std::vector<Image> images;
  for (const Snapshot& one : snapshots) images.push_back(one.image);
  const std::size_t square = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(images.size()))));
  try {
    write_png(file, contact_sheet(images, static_cast<int>(engines > 1 ? engines : square)));
    written.push_back(file.string());
  } catch (const InputError& error) {
    spdlog::info("no contact sheet: {}", error.what());
  }
}

void run(const Session& session, const RenderOptions& options) {
  Scenario scenario = load_scenario(session.scenario_file, {.load_recordings = false});
  const std::vector<std::string> engines = engines_named(options.engine);
  const std::vector<Pose> poses = poses_of(scenario, options);
  for (const int side : {options.picture.width, options.picture.height})
    if (side < 1 || side > kMaxImageSide)
      throw InputError("--width, --height", fmt::format("{} pixels", side), fmt::format("1 to {}", kMaxImageSide));
  if (std::string reason; !render_available(&reason)) throw WorkError("no pictures: " + reason);
  load_meshes(scenario, options.package_paths);
  log_notes(scenario);
  const fs::path folder = session.output_folder(scenario);
  Json pictures = Json::array();
  std::vector<std::string> written;
  const std::vector<Snapshot> snapshots = draw(scenario, poses, engines, options.picture);
  for (const Snapshot& one : snapshots) {
    const fs::path file = folder / fmt::format("{}_{}.png", one.engine, one.pose + 1);
    write_png(file, one.image);
    written.push_back(file.string());
    pictures.push_back({{"file", file.string()}, {"engine", one.engine}, {"q", poses[one.pose].q}});
  }
  write_sheet(folder / "contact_sheet.png", snapshots, engines.size(), written);
  if (session.json) {
    const Json out = {{"format", "lacuna-render/1"},
                      {"version", version()},
                      {"scenario", scenario.name},
                      {"pictures", pictures},
                      {"files", written}};
    print(json_text(out));
    return;
  }
  std::string out;
  for (const std::string& file : written) out += file + "\n";
  print(out);
}

}  // namespace

void add_render(CLI::App& app, Session& session) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App& command = add_scenario_command(
      app, session, "render", "Pictures of the robot (PNG) without a display; -o DIR, else out/<name>",
      "lacuna render my_arm/scenario.yaml --engine all --recording test_1.csv --time 2.5,10 -o pictures",
      [&session, options] { run(session, *options); });
  command.add_option("--engine", options->engine, "Engine, several with commas, or all (default: featherstone)");
  command.add_option("--pose", options->poses, "Q1,Q2,...: one number a joint, rad or m; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--recording", options->recording, "Recording that --time refers to (default: the first)");
  command.add_option("--time", options->times, "T1,T2,...: times on the recording's clock, s");
  add_package_paths(command, options->package_paths);
  command.add_option("--width", options->picture.width, "Pixels (default: 960)");
  command.add_option("--height", options->picture.height, "Pixels (default: 720)");
}

}  // namespace lacuna
