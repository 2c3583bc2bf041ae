#include "reports/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lacuna {
namespace {

constexpr double kLeft = 66.0, kRight = 14.0;  // px, one margin for all plots, so that they align
constexpr double kCharacter = 6.5;             // px, about, at the size of the labels
constexpr char kDashes[] = " stroke-dasharray=\"5 4\"";

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

const char* color_of(Ink ink) {
  switch (ink) {
    case Ink::measured: return "var(--measured,#1a1d22)";
    case Ink::before: return "var(--before,#d4571e)";
    case Ink::after: return "var(--after,#1f62c9)";
    case Ink::other: return "var(--other,#7a5bb5)";
  }
  return "currentColor";
}

/// Cut by characters, never inside one.
std::string shortened(const std::string& any, std::size_t limit) {
  std::size_t shown = 0, i = 0;
  while (i < any.size() && shown < limit) {
    ++i, ++shown;
    while (i < any.size() && (static_cast<unsigned char>(any[i]) & 0xC0) == 0x80) ++i;
  }
  return i < any.size() ? any.substr(0, i) + "\u2026" : any;
}

std::size_t characters(const std::string& any) {
  return static_cast<std::size_t>(
      std::count_if(any.begin(), any.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string superscript(int exponent) {
  static constexpr std::array<const char*, 10> kDigits{"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                                       "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string out = exponent < 0 ? "\u207b" : "";
  for (const char digit : std::to_string(std::abs(exponent))) out += kDigits[digit - '0'];
  return out;
}

std::string axis_title(const std::string& label, const std::string& unit, int exponent) {
  std::string scale = exponent == 0 ? unit : "10" + superscript(exponent) + (unit.empty() ? "" : " " + unit);
  return scale.empty() ? label : label + (label.empty() ? "" : ", ") + scale;
}

std::string words(double x, double y, const char* anchor, const std::string& content, const char* extra = "") {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"currentColor\" fill-opacity=\".72\"{}>{}</text>\n", x,
      y, anchor, extra, escape(content));
}

std::string rule(double x1, double y1, double x2, double y2, double opacity) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"currentColor\" stroke-opacity=\"{}\"/>\n",
      x1, y1, x2, y2, opacity);
}

std::string box(double x, double y, double width, double height, const std::string& fill, double opacity) {
  return fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" style=\"fill:{}\" fill-opacity=\"{}\"/>\n", x,
      y, std::max(width, 0.0), std::max(height, 0.0), fill, opacity);
}

std::string open_svg(int width, int height, const std::string& title, const std::string& description) {
  return fmt::format(
      "<svg class=\"chart\" style=\"max-width:{0}px\" viewBox=\"0 0 {0} {1}\" role=\"img\" font-size=\"12\">"
      "<title>{2}</title><desc>{3}</desc>\n",
      width, height, escape(title), escape(description));
}

/// Marks and words above a plot, in as many rows as they need.
class Legend {
 public:
  explicit Legend(const LinePlot& plot) : right_(plot.width - kRight) {
    for (const Curve& curve : plot.curves) {
      if (curve.label.empty()) continue;
      place(curve.label);
      markup_ += fmt::format(
          "<line x1=\"{0:.1f}\" y1=\"{2:.1f}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" style=\"stroke:{3}\" "
          "stroke-width=\"2.4\"{4}/>\n",
          x_, x_ + 20, y_ - 4, color_of(curve.ink), curve.dashed ? kDashes : "");
      write(curve.label);
    }
    if (plot.band && !plot.band_label.empty()) patch("var(--good,#1b7f46)", plot.band_label);
    if (!plot.shaded.empty() && !plot.shaded_label.empty()) patch("var(--open,#a86400)", plot.shaded_label);
  }

  const std::string& markup() const { return markup_; }
  double height() const { return markup_.empty() ? 12.0 : y_ + 14.0; }

 private:
  static double width_of(const std::string& label) {
    return 26.0 + kCharacter * static_cast<double>(std::min(characters(label), kLongest));
  }
  void place(const std::string& label) {
    if (x_ > kLeft && x_ + width_of(label) > right_) x_ = kLeft, y_ += 18.0;
  }
  void write(const std::string& label) {
    markup_ += words(x_ + 26, y_, "start", shortened(label, kLongest));
    x_ += width_of(label) + 18.0;
  }
  void patch(const char* color, const std::string& label) {
    place(label);
    markup_ += box(x_, y_ - 9, 20, 10, color, 0.3);
    write(label);
  }

  static constexpr std::size_t kLongest = 40;  // characters
  double right_, x_ = kLeft, y_ = 16.0;
  std::string markup_;
};

/// One plot's frame: where the axes lie, in px.
class PlotFrame {
 public:
  PlotFrame(const LinePlot& plot, double top) : plot_(plot), top_(top) {
    bottom_ = plot.height - (plot.x_axis_labels ? 40.0 : 12.0);
    right_ = plot.width - kRight;
    Span x, y;
    for (const Curve& curve : plot.curves) {
      const std::size_t n = std::min(curve.x.size(), curve.y.size());
      for (std::size_t i = 0; i < n; ++i) {
        x.include(along(curve.x[i]));
        y.include(height_of(curve.y[i]));
      }
    }
    if (plot.x_range) x.low = along(plot.x_range->first), x.high = along(plot.x_range->second);
    if (plot.band && !plot.log_y) y.include(plot.band->first), y.include(plot.band->second);
    if (plot.y_limit && !plot.log_y) {
      y.low = std::max(y.low, plot.y_limit->first);
      y.high = std::min(y.high, plot.y_limit->second);
    }
    x_ = plot.log_x ? make_log_axis(x.low, x.high, plot.width / 90) : make_axis(x.low, x.high, plot.width / 90, true);
    const int ticks = std::max(2, static_cast<int>(bottom_ - top_) / 34);
    y_ = plot.log_y ? make_log_axis(y.low, y.high, ticks) : make_axis(y.low, y.high, ticks, false);
  }

  /// `x` in data units.
  double px(double x) const { return across(along(x)); }
  /// `value` in data units.
  double py(double value) const { return at(height_of(value)); }
  /// Data to axis units; NaN where it cannot be drawn.
  double along(double x) const {
    if (!plot_.log_x) return x;
    return x > 0.0 ? std::log10(x) : std::nan("");
  }
  double height_of(double value) const {
    if (!plot_.log_y) return value;
    return value > 0.0 ? std::log10(value) : std::nan("");
  }

  std::string axes() const {
    std::string out;
    for (std::size_t i = 0; i < y_.ticks.size(); ++i) {
      const double y = at(y_.ticks[i]);
      out += rule(kLeft, y, right_, y, y_.ticks[i] == 0.0 && plot_.zero_line ? 0.55 : 0.12);
      out += words(kLeft - 8, y + 4, "end", y_.labels[i]);
    }
    for (std::size_t i = 0; i < x_.ticks.size(); ++i) {
      const double x = across(x_.ticks[i]);
      out += rule(x, bottom_, x, bottom_ + 4, 0.4);
      if (plot_.x_axis_labels) out += words(x, bottom_ + 17, "middle", x_.labels[i]);
    }
    out += rule(kLeft, bottom_, right_, bottom_, 0.4);
    if (plot_.x_axis_labels)
      out += words(right_, bottom_ + 34, "end", axis_title(plot_.x_label, plot_.x_unit, plot_.log_x ? 0 : x_.exponent));
    const std::string turn = fmt::format(" transform=\"rotate(-90 14 {0:.1f})\"", 0.5 * (top_ + bottom_));
    const std::string title = axis_title(plot_.y_label, plot_.y_unit, plot_.log_y ? 0 : y_.exponent);
    return out + words(14, 0.5 * (top_ + bottom_), "middle", title, turn.c_str());
  }

  /// Everything drawn inside is cut at the frame.
  std::string inside(const std::string& content) const {
    return fmt::format(
        "<svg x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2:.1f}\" height=\"{3:.1f}\" "
        "viewBox=\"{0:.1f} {1:.1f} {2:.1f} {3:.1f}\" overflow=\"hidden\">\n{4}</svg>\n",
        kLeft, top_ - 1, right_ - kLeft, bottom_ - top_ + 2, content);
  }

  std::string shading() const {
    std::string out;
    for (const auto& [begin, end] : plot_.shaded) {
      if (!std::isfinite(begin) || !std::isfinite(end)) continue;
      const double from = std::max(px(begin), kLeft), to = std::min(px(end), right_);
      if (to >= from) out += box(from, top_, std::max(to - from, 1.5), bottom_ - top_, "var(--open,#a86400)", 0.16);
    }
    if (plot_.band && std::isfinite(plot_.band->first) && std::isfinite(plot_.band->second)) {
      const double high = std::clamp(py(plot_.band->second), top_, bottom_);
      const double low = std::clamp(py(plot_.band->first), top_, bottom_);
      out += box(kLeft, high, right_ - kLeft, std::max(low - high, 1.0), "var(--good,#1b7f46)", 0.22);
    }
    return out;
  }

  /// The band's edges, to be drawn over the curves.
  std::string band_edges() const {
    std::string out;
    if (!plot_.band) return out;
    for (const double edge : {plot_.band->first, plot_.band->second}) {
      if (!std::isfinite(py(edge))) continue;
      out += fmt::format(
          "<line x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" "
          "style=\"stroke:var(--good,#1b7f46)\"/>\n",
          kLeft, right_, py(edge));
    }
    return out;
  }

 private:
  static double share(double value, const Axis1d& axis) {
    // Far outside is as good as just outside, and keeps the numbers short.
    return std::clamp((value - axis.low) / (axis.high - axis.low), -4.0, 5.0);
  }
  double across(double x) const { return kLeft + (right_ - kLeft) * share(x, x_); }
  double at(double height) const { return bottom_ - (bottom_ - top_) * share(height, y_); }

  const LinePlot& plot_;
  Axis1d x_, y_;
  double top_, bottom_ = 0.0, right_ = 0.0;
};

std::string path_of(const Curve& curve, const PlotFrame& frame) {
  const std::size_t n = std::min(curve.x.size(), curve.y.size());
  std::string path, last;
  bool pen_down = false;
  for (const std::size_t i : decimate(curve.y.first(n))) {
    if (!std::isfinite(frame.along(curve.x[i])) || !std::isfinite(frame.height_of(curve.y[i]))) {
      pen_down = false;
      continue;
    }
    const std::string point = fmt::format("{:.1f},{:.1f}", frame.px(curve.x[i]), frame.py(curve.y[i]));
    if (pen_down && point == last) continue;
    path += (pen_down ? " " : path.empty() ? "M" : " M") + point;
    // A lone point shows as a dot under round caps.
    if (!pen_down) path += " L" + point;
    pen_down = !curve.points;
    last = point;
  }
  if (path.empty()) return {};
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" style=\"stroke:{}\" stroke-width=\"{}\" stroke-linejoin=\"round\" "
      "stroke-linecap=\"round\"{}/>\n",
      path, color_of(curve.ink), curve.width, curve.dashed ? kDashes : "");
}

/// One bar with its label, error bar and value; `px` maps values.
template <class Map>
std::string bar_row(const Bar& bar, double left, double top, double text_x, const Map& px) {
  const double value = std::isfinite(bar.value) ? bar.value : 0.0, middle = top + 10;
  const double from = std::min(px(0.0), px(value)), to = std::max(px(0.0), px(value));
  std::string out = words(left - 10, middle + 4, "end", shortened(bar.label, 38),
                          bar.highlighted ? " font-weight=\"600\" style=\"fill-opacity:1\"" : "");
  out += box(from, top + 3, std::max(to - from, 1.0), 14,
             bar.highlighted ? "var(--after,#1f62c9)" : "var(--muted,#5b626d)", bar.highlighted ? 0.9 : 0.4);
  if (bar.error > 0.0 && std::isfinite(bar.error)) {
    const double low = px(value - bar.error), high = px(value + bar.error);
    out += rule(low, middle, high, middle, 0.9) + rule(low, middle - 4, low, middle + 4, 0.9) +
           rule(high, middle - 4, high, middle + 4, 0.9);
  }
  return out + words(text_x, middle + 4, "start", shortened(bar.words, 20));
}

}  // namespace

Html to_svg(const LinePlot& plot) {
  const Legend legend(plot);
  const PlotFrame frame(plot, legend.height());
  std::string content = frame.shading();
  for (const Curve& curve : plot.curves) content += path_of(curve, frame);
  content += frame.band_edges();
  return {open_svg(plot.width, plot.height, plot.title, plot.description) + legend.markup() + frame.axes() +
          frame.inside(content) + "</svg>\n"};
}

Html to_svg(const HeatMap& map) {
  constexpr double kLeftEdge = 76.0, kTop = 8.0, kBelow = 46.0, kRight = 150.0;
  const std::size_t rows = map.columns == 0 ? 0 : map.values.size() / map.columns;
  double highest = 0.0;
  for (const double v : map.values) highest = std::max(highest, std::isfinite(v) ? std::fabs(v) : 0.0);
  const double right = map.width - kRight, bottom = map.height - kBelow;
  std::string out = open_svg(map.width, map.height, map.title, map.description);
  for (std::size_t k = 0; rows > 0 && k < rows * map.columns; ++k) {
    const double w = (right - kLeftEdge) / static_cast<double>(map.columns),
                 h = (bottom - kTop) / static_cast<double>(rows);
    const double x = kLeftEdge + w * static_cast<double>(k / rows);
    const double y = bottom - h * static_cast<double>(k % rows + 1);
    const double share = std::isfinite(map.values[k]) && highest > 0.0 ? map.values[k] / highest : 0.0;
    out += box(x, y, w, h, color_of(share < 0.0 ? Ink::before : Ink::after), std::fabs(share));
  }
  const auto axis = [](const std::pair<double, double>& range) {
    return make_axis(range.first, range.second, 6, true);
  };
  const Axis1d across = axis(map.x_range), up = axis(map.y_range);
  for (std::size_t i = 0; i < across.ticks.size(); ++i)
    out += words(kLeftEdge + (right - kLeftEdge) * (across.ticks[i] - across.low) / (across.high - across.low),
                 bottom + 16, "middle", across.labels[i]);
  for (std::size_t i = 0; i < up.ticks.size(); ++i)
    out += words(kLeftEdge - 8, bottom - (bottom - kTop) * (up.ticks[i] - up.low) / (up.high - up.low) + 4, "end",
                 up.labels[i]);
  out += words(0.5 * (kLeftEdge + right), bottom + 36, "middle", axis_title(map.x_label, map.x_unit, across.exponent));
  out += words(kLeftEdge, kTop + 4, "start", axis_title(map.y_label, map.y_unit, up.exponent));
  const auto legend = [&](double y, Ink ink, const char* sign) {
    out += box(right + 14, y, 14, 14, color_of(ink), 1.0);
    out += words(right + 34, y + 11, "start", fmt::format("{}{:.3g} {}", sign, highest, map.unit));
  };
  legend(kTop + 10, Ink::after, "+");
  legend(kTop + 32, Ink::before, "-");
  return {out + "</svg>\n"};
}

Html to_svg(const BarChart& chart) {
  constexpr double kRow = 22.0, kValues = 130.0;
  std::size_t longest = 0;
  Span range;
  range.include(0.0);
  for (const Bar& bar : chart.bars) {
    longest = std::max(longest, std::min<std::size_t>(characters(bar.label), 39));
    const double error = std::isfinite(bar.error) ? std::max(bar.error, 0.0) : 0.0;
    range.include(bar.value - error);
    range.include(bar.value + error);
  }
  const double margin = 0.03 * (range.high - range.low);
  const Axis1d axis = make_axis(range.low < 0.0 ? range.low - margin : 0.0, range.high + margin, 6, true);
  const double left = std::max(60.0, kCharacter * static_cast<double>(longest) + 24), right = chart.width - kValues;
  const double bottom = 6 + kRow * static_cast<double>(chart.bars.size());
  const int height = static_cast<int>(bottom) + 42;
  const auto px = [&](double value) { return left + (right - left) * (value - axis.low) / (axis.high - axis.low); };
  std::string out = open_svg(chart.width, height, chart.title, chart.description);
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    const double x = px(axis.ticks[i]);
    out += rule(x, 2, x, bottom, axis.ticks[i] == 0.0 ? 0.55 : 0.12);
    out += words(x, bottom + 16, "middle", axis.labels[i]);
  }
  for (std::size_t i = 0; i < chart.bars.size(); ++i)
    out += bar_row(chart.bars[i], left, 4 + kRow * static_cast<double>(i), right + 12, px);
  out += words(0.5 * (left + right), bottom + 34, "middle", axis_title(chart.x_label, "", axis.exponent));
  return {out + "</svg>\n"};
}

}  // namespace lacuna
