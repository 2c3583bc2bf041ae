// Stands in for assimp_import.cc in builds without assimp.
#include "scenarios/error.h"
#include "scenarios/mesh.h"

namespace lacuna {
namespace {

constexpr const char* kReason =
    "meshes are not drawn: reading them is not built in, it needs assimp (libassimp-dev), LACUNA_WITH_ASSIMP";

}  // namespace

bool meshes_available(std::string* reason) {
  if (reason != nullptr) *reason = kReason;
  return false;
}

Mesh read_mesh(const std::string&, const std::string&, const std::string&, const MeshLimits&) {
  throw WorkError(kReason);
}

}  // namespace lacuna
