#include "reports/zoomable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/json_text.h"
#include "reports/packed.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

std::size_t length_of(const Curve& curve) { return std::min(curve.x.size(), curve.y.size()); }

bool same_base(const Curve& a, const Curve& b) { return a.x.data() == b.x.data() && length_of(a) == length_of(b); }

/// Instants to keep of curves over one base: of each stretch the lowest and the highest of every curve.
std::vector<std::size_t> kept_rows(const std::vector<const Curve*>& curves) {
  const std::size_t n = length_of(*curves.front());
  std::vector<std::size_t> out;
  for (const Curve* curve : curves) {
    const std::vector<std::size_t> own =
        decimate(curve->y.first(n), std::max<std::size_t>(kMostRows / curves.size(), 4));
    out.insert(out.end(), own.begin(), own.end());
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

Json block_of(const std::vector<const Curve*>& curves, const LinePlot& plot) {
  const std::vector<std::size_t> rows =
      length_of(*curves.front()) <= kMostRows ? [&] {
        std::vector<std::size_t> all(length_of(*curves.front()));
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
        return all;
      }() : kept_rows(curves);
  const auto at_rows = [&](std::span<const double> values, bool log) {
    std::vector<double> out;
    out.reserve(rows.size());
    for (const std::size_t i : rows) out.push_back(values[i]);
    return packed(out, log);
  };
  Json block{{"x", at_rows(curves.front()->x, plot.log_x)}, {"curves", Json::array()}};
  for (const Curve* curve : curves) {
    static constexpr const char* kInkNames[] = {"measured", "before", "after", "other"};
    block["curves"].push_back({{"label", curve->label},
                               {"ink", kInkNames[static_cast<std::size_t>(curve->ink)]},
                               {"width", curve->width},
                               {"dashed", curve->dashed},
                               {"points", curve->points},
                               {"y", at_rows(curve->y, plot.log_y)}});
  }
  return block;
}

Json interval(const std::pair<double, double>& of) { return {six_digits(of.first), six_digits(of.second)}; }

/// Whether a browser can draw it over an axis that it may zoom.
bool goes_one_way(const Curve& curve) {
  const std::span<const double> x = curve.x.first(length_of(curve));
  return curve.points || std::is_sorted(x.begin(), x.end()) || std::is_sorted(x.rbegin(), x.rend());
}

/// Whether there is anything to draw of it: on a logarithmic axis nothing below zero can be.
bool is_seen(const Curve& curve, const LinePlot& plot) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < length_of(curve); ++i) {
    const double x = curve.x[i], y = curve.y[i];
    seen += std::isfinite(x) && std::isfinite(y) && (!plot.log_x || x > 0.0) && (!plot.log_y || y > 0.0);
  }
  return seen > 1;
}

Json data_of(const LinePlot& plot) {
  Json out{{"title", plot.title},
           {"x", {{"label", plot.x_label}, {"unit", plot.x_unit}, {"log", plot.log_x}}},
           {"y", {{"label", plot.y_label}, {"unit", plot.y_unit}, {"log", plot.log_y}}},
           {"labels", plot.x_axis_labels},
           {"zero", plot.zero_line},
           {"width", plot.width},
           {"height", plot.height},
           {"recording", plot.recording},
           {"joint", plot.joint}};
  if (plot.x_range) out["x"]["range"] = interval(*plot.x_range);
  if (plot.y_limit) out["y"]["limit"] = interval(*plot.y_limit);
  if (plot.band) out["band"] = interval(*plot.band), out["band_label"] = plot.band_label;
  for (const auto& stretch : plot.shaded) out["shaded"].push_back(interval(stretch));
  if (!plot.shaded.empty()) out["shaded_label"] = plot.shaded_label;
  out["blocks"] = Json::array();
  std::vector<bool> done(plot.curves.size(), false);
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    if (done[i]) continue;
    std::vector<const Curve*> together;
    for (std::size_t k = i; k < plot.curves.size(); ++k) {
      if (done[k] || !same_base(plot.curves[i], plot.curves[k])) continue;
      done[k] = true;
      together.push_back(&plot.curves[k]);
    }
    out["blocks"].push_back(block_of(together, plot));
  }
  return out;
}

}  // namespace

Html zoomable(const LinePlot& plot) {
  const Html drawing = to_svg(plot);
  const bool any =
      std::any_of(plot.curves.begin(), plot.curves.end(), [&](const Curve& c) { return is_seen(c, plot); });
  if (!any || !std::all_of(plot.curves.begin(), plot.curves.end(), goes_one_way)) return drawing;
  return element("div", drawing + data_block("plot-data", script_json(data_of(plot))), "plot");
}

}  // namespace lacuna
