#include "render/simplify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "scenarios/mesh.h"

namespace lacuna {
namespace {

constexpr double kFinest = 1.0 / 1024;  // first cell tried, of the largest mesh
constexpr double kCoarser = 1.4142135623730951;

std::size_t triangles(const std::vector<Solid>& figure) {
  std::size_t sum = 0;
  for (const Solid& solid : figure) sum += solid.mesh ? solid.mesh->triangles.size() : 0;
  return sum;
}

/// Turned so that the smallest index stands first: equal for the same triangle seen from the same side.
std::array<std::uint32_t, 3> turned(std::array<std::uint32_t, 3> corners) {
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

std::vector<Solid> coarse(const std::vector<Solid>& figure, double cell) {
  std::vector<Solid> out = figure;
  std::map<const Mesh*, std::shared_ptr<const Mesh>> done;
  for (Solid& solid : out) {
    if (!solid.mesh) continue;
    std::shared_ptr<const Mesh>& mesh = done[solid.mesh.get()];
    if (!mesh) mesh = std::make_shared<const Mesh>(clustered(*solid.mesh, cell));
    solid.mesh = mesh;
  }
  return out;
}

}  // namespace

Mesh clustered(const Mesh& mesh, double cell) {
  Mesh out;
  out.lower = mesh.lower, out.upper = mesh.upper;  // still placed by the same box
  std::map<std::array<std::int64_t, 3>, std::uint32_t> cells;
  std::vector<std::uint32_t> index;
  std::vector<Eigen::Vector3d> sums;
  std::vector<double> counts;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3d at = (vertex.cast<double>() - mesh.lower) / cell;
    const std::array<std::int64_t, 3> key{std::llround(std::floor(at[0])), std::llround(std::floor(at[1])),
                                          std::llround(std::floor(at[2]))};
    const std::uint32_t i = cells.try_emplace(key, static_cast<std::uint32_t>(sums.size())).first->second;
    if (i == sums.size()) sums.emplace_back(Eigen::Vector3d::Zero()), counts.push_back(0.0);
    sums[i] += vertex.cast<double>(), counts[i] += 1.0;
    index.push_back(i);
  }
  for (std::size_t i = 0; i < sums.size(); ++i) out.vertices.emplace_back((sums[i] / counts[i]).cast<float>());
  std::set<std::array<std::uint32_t, 3>> seen;
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<std::uint32_t, 3> corners = turned({index[a], index[b], index[c]});
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    if (seen.insert(corners).second) out.triangles.push_back(corners);
  }
  return out;
}

std::size_t simplify(std::vector<Solid>& figure, std::size_t most) {
  const std::size_t before = triangles(figure);
  if (before <= most) return 0;
  double largest = 0.0;
  for (const Solid& solid : figure)
    if (solid.mesh) largest = std::max(largest, 2.0 * solid.half.maxCoeff());
  std::vector<Solid> out = figure;
  for (double cell = kFinest * largest; triangles(out) > most; cell *= kCoarser) out = coarse(figure, cell);
  for (Solid& solid : out) {
    if (!solid.mesh || !solid.mesh->triangles.empty()) continue;
    solid.kind = Solid::Kind::box;
    solid.mesh = nullptr;
  }
  figure = std::move(out);
  return before;
}

}  // namespace lacuna
