// The robot as it was measured and as both models move it, to be played in the page (reports/page/replay.js).
#pragma once

#include <span>

#include "diagnosis/diagnosis.h"
#include "reports/html.h"
#include "reports/sections.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// Instants kept of a recording; the page draws in between.
inline constexpr std::size_t kMostFrames = 1200;
/// Triangles kept of a robot's meshes, about 150 kB: the page draws them on a processor, two pictures at a time.
inline constexpr std::size_t kMostTriangles = 8000;

/// Tree, solids, the cylinders of hydraulic actuators among them, camera, and of each recording the joints' positions
/// and missing efforts; any robot. Joints that are not measured stand at zero. Nothing where no positions are compared
/// or a clock runs back.
Html replay_section(const Scenario& scenario, std::span<const Replay> replays, const TraceWords& words);

}  // namespace lacuna
