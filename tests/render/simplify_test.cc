#include "render/simplify.h"

#include <gtest/gtest.h>

#include "tests/scenarios/mesh_writer.h"

namespace lacuna {
namespace {

std::vector<Solid> figure_of(const std::vector<Mesh>& meshes) {
  std::vector<Solid> out;
  for (const Mesh& mesh : meshes) {
    out.push_back({Solid::Kind::mesh, 0.5 * (mesh.upper - mesh.lower)});
    out.back().mesh = std::make_shared<const Mesh>(mesh);
  }
  return out;
}

std::size_t triangles(const std::vector<Solid>& figure) {
  std::size_t sum = 0;
  for (const Solid& solid : figure) sum += solid.mesh ? solid.mesh->triangles.size() : 0;
  return sum;
}

TEST(Simplify, LeavesAloneWhatIsSmallEnough) {
  std::vector<Solid> figure = figure_of({test::ball_mesh(1.0f, 10)});
  const auto mesh = figure[0].mesh;
  EXPECT_EQ(simplify(figure, 180), 0u);
  EXPECT_EQ(figure[0].mesh, mesh);
}

TEST(Simplify, ABallStaysABallOfFewerTriangles) {
  std::vector<Solid> figure = figure_of({test::ball_mesh(1.0f, 60)});
  EXPECT_EQ(simplify(figure, 1000), 7080u);
  EXPECT_LE(triangles(figure), 1000u);
  EXPECT_GT(triangles(figure), 300u) << "no coarser than it must be: one step of the cell halves their number";
  // A mean of points of the sphere in a cell lies inside by less than the cell; 1,000 triangles are cells of about
  // 0.15.
  for (const Eigen::Vector3f& vertex : figure[0].mesh->vertices) EXPECT_NEAR(vertex.norm(), 1.0, 0.05);
  for (const auto& triangle : figure[0].mesh->triangles)
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, figure[0].mesh->vertices.size());
}

TEST(Simplify, OfAMeshThatVanishesItsBoxIsLeft) {
  std::vector<Solid> figure = figure_of({test::ball_mesh(1.0f, 60), test::ball_mesh(0.01f, 8)});
  simplify(figure, 300);
  EXPECT_EQ(figure[1].kind, Solid::Kind::box);
  EXPECT_EQ(figure[1].mesh, nullptr);
  EXPECT_NEAR(figure[1].half[0], 0.01, 1e-6);
}

TEST(Simplify, OneCellLeavesNothingAndEqualTrianglesAreOne) {
  const Mesh box = test::box_mesh({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(clustered(box, 10.0).triangles.empty());
  EXPECT_EQ(clustered(box, 0.1).triangles.size(), 12u);
  Mesh twice = box;
  twice.triangles.insert(twice.triangles.end(), box.triangles.begin(), box.triangles.end());
  EXPECT_EQ(clustered(twice, 0.1).triangles.size(), 12u);
}

}  // namespace
}  // namespace lacuna
