#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

constexpr double kNormal95 = 1.96;

Html plot(const Whiteness& w, bool two) {
  std::vector<double> lags;
  for (std::size_t k = 0; k < std::max(w.before.size(), w.after.size()); ++k)
    lags.push_back(static_cast<double>(k + 1));
  LinePlot out;
  out.title = "Autocorrelation of the residual at " + w.joint;
  out.description = "By lag in samples, on recordings that were not fitted; white noise stays within the band.";
  out.x_label = "lag";
  out.x_unit = "samples";
  out.y_label = "autocorrelation, " + w.joint;
  if (two) out.curves.push_back({"before", lags, w.before, Ink::before});
  out.curves.push_back({two ? "after" : "", lags, w.after, Ink::after});
  const double reach = kNormal95 / std::sqrt(std::max(w.samples, 1.0));
  out.band = {-reach, reach};
  out.band_label = "white noise, 95 %";
  out.zero_line = true;
  out.height = 170;
  return zoomable(out);
}

}  // namespace

Html whiteness_section(std::span<const Whiteness> joints, std::span<const std::string> drawn, bool two) {
  if (joints.empty()) return {};
  std::vector<Table::Column> heads{{"joint"}};
  if (two) heads.insert(heads.end(), {{"lag 1, before", true}, {"chance, before", true}});
  heads.insert(heads.end(), {{two ? "lag 1, after" : "lag 1", true}, {two ? "chance, after" : "chance", true}});
  Table table(heads);
  Html plots;
  for (const Whiteness& w : joints) {
    std::vector<Html> cells{element("code", text(w.joint))};
    if (two) cells.insert(cells.end(), {text(number(w.before.front(), 2)), text(chance_words(w.p_before))});
    cells.insert(cells.end(), {text(number(w.after.front(), 2)), text(chance_words(w.p_after))});
    table.row(cells);
    if (std::find(drawn.begin(), drawn.end(), w.joint) != drawn.end()) plots += plot(w, two);
  }
  return plots + table.html() +
         paragraph(
             fmt::format("Residuals of the {} recordings. A model that leaves nothing out leaves the sensor's noise. "
                         "Where that is white, the autocorrelations stay within the band; chance: of so much colour in "
                         "white noise (Ljung and Box, {} lags). Noise that is coloured or quantised shows here with "
                         "any model.",
                         to_string(joints.front().role), joints.front().after.size()),
             "muted small");
}

}  // namespace lacuna
