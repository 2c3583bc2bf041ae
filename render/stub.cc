// Stands in for osmesa_snapshot.cc in builds without OSMesa or without MuJoCo's renderer.
#include "render/snapshot.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

constexpr const char* kReason =
    "pictures are not built in: they need OSMesa (libosmesa6-dev) and MuJoCo (libmujoco-dev), "
    "LACUNA_WITH_RENDER and LACUNA_WITH_MUJOCO";

}  // namespace

bool render_available(std::string* reason) {
  if (reason) *reason = kReason;
  return false;
}

Image render_snapshot(const Robot&, std::span<const Eigen::Isometry3d>, const Camera&, const SnapshotOptions&) {
  throw WorkError(kReason);
}

}  // namespace lacuna
