// Pose snapshots from every engine's own link poses.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/image.h"
#include "reports/report.h"
#include "scenarios/scenario.h"

namespace CLI {
class App;
}

namespace lacuna {

/// A configuration of the robot and what is said about it in a picture.
struct Pose {
  std::vector<double> q;  ///< rad or m
  std::string words;
};

/// Measured positions at `time` (s, on the recording's own clock), linear between samples; joints that were not
/// measured stand at 0. Throws InputError for a time outside the recording.
Pose pose_at(const Scenario& scenario, const RecordingSpec& spec, double time);

struct PoseOptions {
  int width = 960, height = 720;    ///< pixels
  std::vector<std::string> marked;  ///< joints with a ring about them
};

/// Package paths: folders given by `--package-path`, any number.
void add_package_paths(CLI::App& command, std::vector<std::string>& folders);
/// Reads the meshes that the scenario's robot names, so that they are drawn; what is left undrawn is noted. Throws
/// InputError for a file that is found and no mesh.
void load_meshes(Scenario& scenario, const std::vector<std::string>& package_paths);

struct Snapshot {
  std::string engine;
  std::size_t pose = 0;  ///< index
  Image image;
};

/// One picture: a pose as one engine's link poses have it.
struct Drawing {
  std::string engine;
  std::vector<double> q;  ///< rad or m
  std::string caption, subcaption;
};
/// All from one camera, fitted to the first engine's. A pose that is not finite gives an empty picture. Throws
/// WorkError where drawing is not possible.
std::vector<Image> draw(const Scenario& scenario, const std::vector<Drawing>& drawings, const PoseOptions& options);

/// Every pose on every engine, all from one camera, pose by pose. Throws WorkError where drawing is not possible.
std::vector<Snapshot> draw(const Scenario& scenario, const std::vector<Pose>& poses,
                           const std::vector<std::string>& engines, const PoseOptions& options);

/// For a report: the arm in the middle of the first test recording (else the first one), on every engine built in.
/// PNG files pose_<engine>.png in `folder` too. Empty, with a note in the log, where drawing is not possible.
std::vector<Picture> report_pictures(const std::filesystem::path& folder, const Scenario& scenario,
                                     const std::vector<std::string>& marked);

}  // namespace lacuna
