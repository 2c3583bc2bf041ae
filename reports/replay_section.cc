#include "reports/replay_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "backends/engine.h"
#include "render/camera.h"
#include "render/figure.h"
#include "render/pistons.h"
#include "render/simplify.h"
#include "reports/json_text.h"
#include "reports/packed.h"
#include "scenarios/mesh.h"
#include "scenarios/robot.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPoses = 12;   // that the camera must see
constexpr double kMeshSteps = 4095;  // of a mesh's coordinates along each side of its box

Json numbers(std::span<const double> values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(six_digits(v));
  return out;
}
Json numbers(const Eigen::Vector3d& v) { return numbers(std::span(v.data(), 3)); }
/// Rotation by columns, then translation.
Json numbers(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix<double, 3, 4> top = pose.affine();
  return numbers(std::span(top.data(), 12));
}

Json tree_of(const Robot& robot) {
  Json out = Json::array();
  for (const Joint& joint : robot.joints())
    out.push_back({{"name", joint.name},
                   {"slides", joint.prismatic()},
                   {"parent", joint.parent},
                   {"origin", numbers(joint.origin)},
                   {"axis", numbers(joint.axis)}});
  return out;
}

/// Vertices in whole steps of the box from its lower corner, triangles as three indices each.
void add_mesh(const Mesh& mesh, Json& out) {
  Json vertices = Json::array(), triangles = Json::array();
  const Eigen::Vector3d sides = (mesh.upper - mesh.lower).cwiseMax(1e-12);
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    for (int k = 0; k < 3; ++k)
      vertices.push_back(
          std::lround(kMeshSteps * std::clamp((static_cast<double>(vertex[k]) - mesh.lower[k]) / sides[k], 0.0, 1.0)));
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) triangles.push_back(corner);
  out["steps"] = kMeshSteps;
  out["vertices"] = std::move(vertices);
  out["triangles"] = std::move(triangles);
}

/// In the frame of the body that carries it.
Json json_of(const Solid& solid, std::span<const Eigen::Isometry3d> bodies) {
  static constexpr const char* kKinds[] = {"box", "cylinder", "capsule", "sphere", "mesh"};
  const Eigen::Isometry3d pose = solid.body < 0 ? solid.pose : bodies[solid.body].inverse() * solid.pose;
  Json out{{"body", solid.body},
           {"kind", kKinds[static_cast<std::size_t>(solid.kind)]},
           {"half", numbers(solid.half)},
           {"pose", numbers(pose)},
           {"color", {six_digits(solid.rgba[0]), six_digits(solid.rgba[1]), six_digits(solid.rgba[2])}}};
  if (solid.mesh) add_mesh(*solid.mesh, out);
  return out;
}

/// Pins as any solid. Barrel and rod lie between them at every instant ("between": their places in `out`), the barrel
/// from its pin on, the rod from the barrel's end ("barrel", m).
void add_piston(const Piston& piston, std::span<const Solid> parts, std::span<const Eigen::Isometry3d> bodies,
                Json& out) {
  const std::size_t first = out.size();
  for (const Solid& part : parts) out.push_back(json_of(part, bodies));
  for (const std::size_t k : {0, 1}) {
    out[first + k]["between"] = {first + 2, first + 3};
    out[first + k]["barrel"] = six_digits(piston.barrel);
    out[first + k]["part"] = k == 0 ? "barrel" : "rod";
  }
}

/// `note` says where meshes were made coarser.
Json solids_of(const Robot& robot, std::span<const Piston> pistons, Dynamics& dynamics, double ground,
               std::string& note) {
  std::vector<Eigen::Isometry3d> bodies;
  dynamics.body_poses(std::vector<double>(static_cast<std::size_t>(robot.dof())), bodies);
  const std::vector<Eigen::Isometry3d> links = robot.link_poses(bodies);
  std::vector<Solid> solids = robot_figure(robot, links);
  if (const std::optional<Solid> post = pillar(robot, ground)) solids.push_back(*post);
  if (const std::size_t before = simplify(solids, kMostTriangles); before > 0) {
    std::size_t kept = 0;
    for (const Solid& solid : solids) kept += solid.mesh ? solid.mesh->triangles.size() : 0;
    note = fmt::format("The meshes are drawn coarser here: {} of their {} triangles.", kept, before);
  }
  Json out = Json::array();
  for (const Solid& solid : solids) out.push_back(json_of(solid, bodies));
  for (const Piston& piston : pistons) add_piston(piston, piston_figure(robot, links, piston), bodies, out);
  return out;
}

std::vector<std::size_t> even_rows(std::size_t n) {
  const std::size_t kept = std::min(n, kMostFrames);
  std::vector<std::size_t> out(kept);
  for (std::size_t k = 0; k < kept; ++k) out[k] = kept < 2 ? 0 : k * (n - 1) / (kept - 1);
  return out;
}

Json picked(std::span<const double> values, const std::vector<std::size_t>& rows) {
  std::vector<double> out;
  for (const std::size_t i : rows) out.push_back(i < values.size() ? values[i] : std::nan(""));
  return packed(out);
}

Json errors(const std::vector<double>& model, const std::vector<double>& measured,
            const std::vector<std::size_t>& rows) {
  if (model.empty()) return nullptr;
  std::vector<double> out;
  for (const std::size_t i : rows) out.push_back(i < model.size() ? model[i] - measured[i] : std::nan(""));
  return packed(out);
}

Json recording_of(const Replay& replay, const Robot& robot) {
  const std::vector<std::size_t> rows = even_rows(replay.traces.front().time.size());
  Json joints = Json::array();
  for (const Trace& trace : replay.traces) {
    const std::optional<int> index = robot.find_joint(trace.joint);
    if (!index) continue;
    joints.push_back({{"joint", *index},
                      {"unit", trace.unit},
                      {"measured", picked(trace.measured, rows)},
                      {"before", errors(trace.before, trace.measured, rows)},
                      {"after", errors(trace.after, trace.measured, rows)}});
  }
  Json missing = Json::array();
  for (const Replay::Effort& effort : replay.missing) {
    const std::optional<int> index = robot.find_joint(effort.joint);
    if (!index || effort.time.empty()) continue;
    const std::vector<std::size_t> own = even_rows(effort.time.size());
    missing.push_back({{"joint", *index},
                       {"unit", effort.unit},
                       {"noise", six_digits(effort.noise)},
                       {"time", picked(effort.time, own)},
                       {"before", picked(effort.before, own)},
                       {"after", effort.after.empty() ? Json() : picked(effort.after, own)}});
  }
  return {{"name", replay.recording},
          {"role", to_string(replay.role)},
          {"time", picked(replay.traces.front().time, rows)},
          {"joints", std::move(joints)},
          {"missing", std::move(missing)}};
}

/// Every joint's measured position at some instants, where it is finite.
std::vector<std::vector<double>> poses_of(const Replay& replay, const Robot& robot) {
  std::vector<std::vector<double>> out;
  const std::size_t n = replay.traces.front().time.size();
  for (std::size_t k = 0; k < kPoses; ++k) {
    out.emplace_back(static_cast<std::size_t>(robot.dof()), 0.0);
    for (const Trace& trace : replay.traces) {
      const std::optional<int> index = robot.find_joint(trace.joint);
      const std::size_t i = k * (n - 1) / (kPoses - 1);
      if (index && i < trace.measured.size() && std::isfinite(trace.measured[i]))
        out.back()[*index] = trace.measured[i];
    }
  }
  return out;
}

Camera camera_of(std::span<const Replay> replays, const Robot& robot, Dynamics& dynamics) {
  std::vector<std::vector<Eigen::Isometry3d>> poses;
  std::vector<Eigen::Isometry3d> bodies;
  for (const Replay& replay : replays) {
    for (const std::vector<double>& q : poses_of(replay, robot)) {
      dynamics.body_poses(q, bodies);
      poses.push_back(robot.link_poses(bodies));
    }
  }
  return fit_camera(robot, poses);
}

Json json_of(const Camera& camera) {
  return {{"target", numbers(camera.target)},         {"distance", six_digits(camera.distance)},
          {"azimuth", six_digits(camera.azimuth)},    {"elevation", six_digits(camera.elevation)},
          {"view", six_digits(camera.field_of_view)}, {"aspect", six_digits(camera.aspect)},
          {"radius", six_digits(camera.radius)},      {"ground", six_digits(camera.ground)}};
}

bool can_be_played(const Replay& replay) {
  if (replay.traces.empty() || replay.traces.front().time.size() < 2) return false;
  const std::vector<double>& time = replay.traces.front().time;
  return std::is_sorted(time.begin(), time.end());
}

}  // namespace

Html replay_section(const Scenario& scenario, std::span<const Replay> all, const TraceWords& words) {
  if (!scenario.robot || std::holds_alternative<InverseDynamics>(scenario.prediction)) return {};
  std::vector<Replay> replays;
  std::copy_if(all.begin(), all.end(), std::back_inserter(replays), can_be_played);
  if (replays.empty()) return {};
  const Robot& robot = *scenario.robot;
  const std::unique_ptr<Dynamics> dynamics = find_engine("featherstone").build(scenario.robot, scenario.gravity);
  const Camera camera = camera_of(replays, robot, *dynamics);
  Json recordings = Json::array();
  for (const Replay& replay : replays) recordings.push_back(recording_of(replay, robot));
  std::string note;
  Json solids = solids_of(robot, pistons_of(scenario), *dynamics, camera.ground, note);
  const Json data{{"joints", tree_of(robot)},
                  {"solids", std::move(solids)},
                  {"camera", json_of(camera)},
                  {"words", {words.before, words.after}},
                  {"recordings", std::move(recordings)}};
  return element("div",
                 element("noscript", paragraph("The replay needs a browser that runs scripts.", "muted")) +
                     data_block("replay-data", script_json(data)),
                 "replay") +
         (note.empty() ? Html() : paragraph(note, "muted"));
}

}  // namespace lacuna
