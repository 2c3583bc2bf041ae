// Geoms of MJCF: what they weigh, and how they are drawn.
#pragma once

#include <optional>

#include "scenarios/mjcf_attributes.h"
#include "scenarios/robot.h"

namespace lacuna {

/// A geom of simple shape in its body's frame; `visual` is empty for shapes that are not drawn.
struct MjcfGeom {
  Inertial inertial;  ///< in the body's frame; mass 0 where it says so, and for planes
  std::optional<Visual> visual;
  bool mesh = false;  ///< its mass, if any, is not known
};

/// Box, sphere, cylinder, capsule, ellipsoid by size or `fromto`, weighed by `mass` or `density` (1000 kg/m^3). Throws
/// InputError for sizes that are not positive.
MjcfGeom read_mjcf_geom(const MjcfAttributes& attributes, int element);

}  // namespace lacuna
