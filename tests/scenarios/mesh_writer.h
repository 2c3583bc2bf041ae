// Small meshes as files of every kind that is read, and as we hold them; made here, none comes from elsewhere.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>

#include "scenarios/mesh.h"

namespace lacuna::test {

inline void find_box(Mesh& mesh) {
  mesh.lower = mesh.upper = mesh.vertices.front().cast<double>();
  for (const Eigen::Vector3f& v : mesh.vertices) {
    mesh.lower = mesh.lower.cwiseMin(v.cast<double>());
    mesh.upper = mesh.upper.cwiseMax(v.cast<double>());
  }
}

/// A box with its lower corner at `lower`, twelve triangles that look outwards.
inline Mesh box_mesh(const Eigen::Vector3f& lower, const Eigen::Vector3f& sides) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(lower +
                            sides.cwiseProduct(Eigen::Vector3f(float(i & 1), float(i >> 1 & 1), float(i >> 2))));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  find_box(mesh);
  return mesh;
}

/// A ball about the origin, 2 n (n - 1) triangles.
inline Mesh ball_mesh(float radius, std::uint32_t n) {
  Mesh mesh;
  const auto at = [&](std::uint32_t ring, std::uint32_t k) {
    return ring == 0 ? 0u : ring == n ? 1u : 2 + (ring - 1) * n + k % n;
  };
  mesh.vertices = {{0, 0, -radius}, {0, 0, radius}};
  for (std::uint32_t ring = 1; ring < n; ++ring)
    for (std::uint32_t k = 0; k < n; ++k) {
      const float a = std::numbers::pi_v<float> * (float(ring) / float(n) - 0.5f);
      const float b = 2 * std::numbers::pi_v<float> * float(k) / float(n);
      mesh.vertices.emplace_back(radius * std::cos(a) * std::cos(b), radius * std::cos(a) * std::sin(b),
                                 radius * std::sin(a));
    }
  for (std::uint32_t ring = 0; ring < n; ++ring)
    for (std::uint32_t k = 0; k < n; ++k) {
      if (ring > 0) mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k)});
      if (ring + 1 < n) mesh.triangles.push_back({at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)});
    }
  find_box(mesh);
  return mesh;
}

inline std::string text_stl(const Mesh& mesh) {
  std::string out = "solid made\n";
  for (const auto& triangle : mesh.triangles) {
    out += "facet normal 0 0 0\n outer loop\n";
    for (const std::uint32_t i : triangle)
      out += fmt::format("  vertex {} {} {}\n", mesh.vertices[i][0], mesh.vertices[i][1], mesh.vertices[i][2]);
    out += " endloop\nendfacet\n";
  }
  return out + "endsolid made\n";
}

inline std::string binary_stl(const Mesh& mesh) {
  std::string out(80, ' ');
  const auto put = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    put(std::array<float, 3>{});
    for (const std::uint32_t i : triangle) put(mesh.vertices[i]);
    put(std::uint16_t{0});
  }
  return out;
}

inline std::string obj(const Mesh& mesh) {
  std::string out = "mtllib elsewhere.mtl\no made\n";
  for (const Eigen::Vector3f& v : mesh.vertices) out += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  for (const auto& [a, b, c] : mesh.triangles) out += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  return out;
}

/// In centimetres, z up, one node at `x` cm along x; `attack` goes into the node.
inline std::string collada(const Mesh& mesh, double x, const std::string& attack = "") {
  std::string points, indices;
  for (const Eigen::Vector3f& v : mesh.vertices) points += fmt::format("{} {} {} ", v[0], v[1], v[2]);
  for (const auto& [a, b, c] : mesh.triangles) indices += fmt::format("{} {} {} ", a, b, c);
  return fmt::format(R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{0}">{1}</float_array><technique_common>
<accessor source="#a" count="{2}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{3}"><input semantic="VERTEX" source="#v" offset="0"/><p>{4}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>{5} 0 0</translate><instance_geometry url="#g"/>{6}</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
                     3 * mesh.vertices.size(), points, mesh.vertices.size(), mesh.triangles.size(), indices, x, attack);
}

}  // namespace lacuna::test
