// Plots as SVG markup to be put into a page: lines over time, bars with error bars, and maps over two variables.
//
// Colours are the page's CSS variables with a light fallback, everything else follows currentColor: one drawing serves
// light, dark and paper. Any data will do: empty, constant, of different lengths, not finite, of any size.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "reports/html.h"

namespace lacuna {

enum class Ink { measured, before, after, other };

/// `x` and `y` are not copied; the longer one is cut. Points that are not finite break the line.
struct Curve {
  std::string label;  ///< empty: not in the legend
  std::span<const double> x, y;
  Ink ink = Ink::measured;
  double width = 1.4;
  bool dashed = false;
  bool points = false;  ///< apart, with no line between them
};

struct LinePlot {
  std::string title;  ///< for screen readers
  std::string description;
  std::string x_label, x_unit, y_label, y_unit;
  std::vector<Curve> curves;
  std::vector<std::pair<double, double>> shaded;  ///< intervals of x
  std::string shaded_label;
  std::optional<std::pair<double, double>> band;  ///< of y, shaded
  std::string band_label;
  std::optional<std::pair<double, double>> y_limit;  ///< what the y axis never exceeds; curves beyond are clipped
  std::optional<std::pair<double, double>> x_range;  ///< given: the x axis, so that plots align
  bool zero_line = false;
  bool log_x = false, log_y = false;  ///< points that are not positive are left out
  bool x_axis_labels = true;
  std::string recording,
      joint;  ///< what is plotted over time; plots of one recording share cursor and zoom (zoomable.h)
  int width = 960, height = 240;
};

struct Bar {
  std::string label;
  double value = 0.0, error = 0.0;
  std::string words;  ///< the value as it is written beside the bar
  bool highlighted = false;
};

/// Horizontal bars, top to bottom.
struct BarChart {
  std::string title, description, x_label;
  std::vector<Bar> bars;
  int width = 960;
};

/// Values on an even grid: above zero in the one colour, below in the other, the darker the larger.
struct HeatMap {
  std::string title, description;
  std::string x_label, x_unit, y_label, y_unit, unit;
  std::pair<double, double> x_range, y_range;  ///< of the outermost grid lines
  std::size_t columns = 0;                     ///< grid lines of x
  std::vector<double> values;                  ///< those of one x next to each other, y rising
  int width = 960, height = 320;
};

Html to_svg(const LinePlot& plot);
Html to_svg(const BarChart& chart);
Html to_svg(const HeatMap& map);

/// At most about this many points are drawn a curve.
inline constexpr std::size_t kMostPoints = 1500;

/// Indices of the samples to draw: all, or of each stretch its lowest and highest, so that no peak is lost.
std::vector<std::size_t> decimate(std::span<const double> y, std::size_t most = kMostPoints);

/// An axis over [low, high], widened where they are equal or not finite.
struct Axis1d {
  double low = 0.0, high = 1.0;
  std::vector<double> ticks;        ///< within [low, high]
  std::vector<std::string> labels;  ///< in units of 10^exponent
  int exponent = 0;
};
/// `tight`: ends at low and high, else at ticks.
Axis1d make_axis(double low, double high, int most_ticks, bool tight);
/// The same for a logarithmic axis: low and high in decades (log10).
Axis1d make_log_axis(double low, double high, int most_ticks);

}  // namespace lacuna
