// A plot for the page: the drawing, and beside it what a browser with scripts makes it anew from, to zoom and to share
// a cursor (reports/page/plots.js).
#pragma once

#include "reports/html.h"
#include "reports/svg.h"

namespace lacuna {

/// The drawing with its data. Curves of one time base are thinned together, so that no peak is lost, to about
/// `kMostRows` instants; values keep 1e-5 of their curve's range, on logarithmic axes six digits. A plot with
/// nothing to draw, or with a line whose x goes back and forth, stays a drawing.
inline constexpr std::size_t kMostRows = 2500;
Html zoomable(const LinePlot& plot);

}  // namespace lacuna
