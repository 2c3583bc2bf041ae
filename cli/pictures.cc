#include "cli/pictures.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>

#include "backends/engine.h"
#include "cli/command.h"
#include "render/pistons.h"
#include "render/snapshot.h"
#include "scenarios/error.h"
#include "scenarios/mesh.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

const std::vector<double>& column_of(const Recording& data, const std::string& name) {
  return data.columns[data.find(name)];
}

/// Linear between the nearest samples that hold a value; 0 where none does.
double value_at(const std::vector<double>& time, const std::vector<double>& values, double t) {
  const std::size_t after = std::lower_bound(time.begin(), time.end(), t) - time.begin();
  std::size_t right = after, left = after;
  while (right < time.size() && !std::isfinite(values[right])) ++right;
  while (left > 0 && !std::isfinite(values[left - 1])) --left;
  if (right == time.size()) return left > 0 ? values[left - 1] : 0.0;
  if (left == 0 || time[right] <= t) return values[right];
  const double share = (t - time[left - 1]) / (time[right] - time[left - 1]);
  return values[left - 1] + share * (values[right] - values[left - 1]);
}

/// The entry that a picture for a report is taken from.
const RecordingSpec* picture_recording(const Scenario& scenario) {
  for (const RecordingSpec& spec : scenario.recordings)
    if (spec.role == Role::test) return &spec;
  return scenario.recordings.empty() ? nullptr : &scenario.recordings.front();
}

/// World poses of the links; empty for a pose that is not finite.
std::vector<std::vector<Eigen::Isometry3d>> link_poses(const Scenario& scenario, const std::vector<Drawing>& drawings) {
  std::map<std::string, std::unique_ptr<Dynamics>> built;
  std::vector<std::vector<Eigen::Isometry3d>> out;
  std::vector<Eigen::Isometry3d> bodies;
  for (const Drawing& drawing : drawings) {
    out.emplace_back();
    if (!std::all_of(drawing.q.begin(), drawing.q.end(), [](double q) { return std::isfinite(q); })) continue;
    std::unique_ptr<Dynamics>& dynamics = built[drawing.engine];
    if (!dynamics) dynamics = find_engine(drawing.engine).build(scenario.robot, scenario.gravity);
    dynamics->body_poses(drawing.q, bodies);
    out.back() = scenario.robot->link_poses(bodies);
  }
  return out;
}

}  // namespace

void add_package_paths(CLI::App& command, std::vector<std::string>& folders) {
  command
      .add_option("--package-path", folders,
                  "DIR: where package://NAME/... of the robot's meshes lies (DIR/NAME/...); may be repeated")
      ->allow_extra_args(false);
}

void load_meshes(Scenario& scenario, const std::vector<std::string>& package_paths) {
  const std::filesystem::path file = scenario.folder() / scenario.robot_file;
  std::vector<std::string> notes;
  scenario.robot =
      with_meshes(*scenario.robot, {file.parent_path(), {package_paths.begin(), package_paths.end()}}, notes);
  for (const std::string& note : notes) scenario.notes.push_back(printable(scenario.robot_file) + ": " + note);
}

Pose pose_at(const Scenario& scenario, const RecordingSpec& spec, double time) {
  const Recording& data = *spec.data;
  const std::vector<double>& clock = column_of(data, scenario.channels.time);
  if (!(time >= clock.front() && time <= clock.back())) {
    throw InputError(printable(spec.file) + ": time", format_number(time) + " s",
                     fmt::format("a time from {} to {} s", format_number(clock.front()), format_number(clock.back())));
  }
  Pose out;
  out.words = fmt::format("{}, t = {} s", std::filesystem::path(spec.file).filename().string(), format_number(time));
  const auto positions = scenario.channels.of.find(ChannelKind::position);
  for (const Joint& joint : scenario.robot->joints()) {
    out.q.push_back(0.0);
    if (positions == scenario.channels.of.end()) continue;
    const auto at = positions->second.find(joint.name);
    if (at == positions->second.end()) continue;
    out.q.back() = at->second.scale * value_at(clock, column_of(data, at->second.column), time) + at->second.offset;
  }
  return out;
}

std::vector<Image> draw(const Scenario& scenario, const std::vector<Drawing>& drawings, const PoseOptions& options) {
  if (std::string reason; !render_available(&reason)) throw WorkError("no pictures: " + reason);
  const auto poses = link_poses(scenario, drawings);
  std::vector<std::vector<Eigen::Isometry3d>> fitted;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    if (drawings[i].engine == drawings.front().engine && !poses[i].empty()) fitted.push_back(poses[i]);
  }
  if (fitted.empty()) throw WorkError("no pictures: no pose is finite");
  const Camera camera = fit_camera(*scenario.robot, fitted, static_cast<double>(options.width) / options.height);
  SnapshotOptions snapshot;
  snapshot.width = options.width;
  snapshot.height = options.height;
  snapshot.pistons = pistons_of(scenario);
  for (const std::string& name : options.marked) {
    Marker marker;
    marker.joint = scenario.robot->find_joint(name).value_or(-1);
    if (marker.joint >= 0) snapshot.markers.push_back(marker);
  }
  std::vector<Image> out;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    snapshot.caption = drawings[i].caption;
    snapshot.subcaption = drawings[i].subcaption;
    out.push_back(poses[i].empty() ? Image::filled(options.width, options.height, 255, 255, 255)
                                   : render_snapshot(*scenario.robot, poses[i], camera, snapshot));
  }
  return out;
}

std::vector<Snapshot> draw(const Scenario& scenario, const std::vector<Pose>& poses,
                           const std::vector<std::string>& engines, const PoseOptions& options) {
  std::vector<Drawing> drawings;
  for (const Pose& pose : poses) {
    for (const std::string& engine : engines) drawings.push_back({engine, pose.q, engine, pose.words});
  }
  std::vector<Image> images = draw(scenario, drawings, options);
  std::vector<Snapshot> out;
  for (std::size_t i = 0; i < images.size(); ++i)
    out.push_back({drawings[i].engine, i / engines.size(), std::move(images[i])});
  return out;
}

std::vector<Picture> report_pictures(const std::filesystem::path& folder, const Scenario& scenario,
                                     const std::vector<std::string>& marked) {
  const RecordingSpec* spec = picture_recording(scenario);
  if (std::string reason; !render_available(&reason)) {
    spdlog::info("no pictures: {}", reason);
    return {};
  }
  if (spec == nullptr) return {};
  const std::vector<double>& clock = column_of(*spec->data, scenario.channels.time);
  const double from = std::max(clock.front(), spec->from.value_or(clock.front()));
  const double to = std::min(clock.back(), spec->to.value_or(clock.back()));
  // On a sample of the clock, so that the caption's time is a short number.
  const auto middle = std::lower_bound(clock.begin(), clock.end(), 0.5 * (from + to));
  PoseOptions options;
  options.marked = marked;
  std::vector<Picture> out;
  for (const Snapshot& one : draw(scenario, {pose_at(scenario, *spec, *middle)}, engines_named("all"), options)) {
    write_png(folder / ("pose_" + one.engine + ".png"), one.image);
    out.push_back({one.engine, encode_png(one.image)});
  }
  return out;
}

}  // namespace lacuna
