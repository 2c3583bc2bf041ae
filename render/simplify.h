// Fewer triangles for a page that has to carry and draw them by itself.
#pragma once

#include <cstddef>
#include <vector>

#include "render/figure.h"

namespace lacuna {

struct Mesh;

/// The mesh with all vertices of a cube of side `cell` (m, above 0) drawn together into their mean; triangles that
/// collapse are dropped, of those that coincide one is kept. May have no triangles left. Deterministic.
Mesh clustered(const Mesh& mesh, double cell);

/// Coarsens all meshes of a figure alike until they have at most `most` triangles together; of a mesh that vanishes the
/// box around it is left. Returns how many triangles there were, 0 where nothing was changed.
std::size_t simplify(std::vector<Solid>& figure, std::size_t most);

}  // namespace lacuna
