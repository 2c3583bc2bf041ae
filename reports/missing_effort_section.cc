#include <fmt/format.h>

#include <algorithm>

#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

bool beyond_noise(const MissingEffort& m) { return m.p_value < kLocateError; }

constexpr std::size_t kMostShown = 3;  // regions and quantities in the table; the JSON file has all

std::string region_words(const MissingEffort& m) {
  std::vector<std::string> out;
  for (const RegionTest& r : std::span(m.regions).first(std::min(kMostShown, m.regions.size())))
    out.push_back(fmt::format("{} ({:.1f} times the power)", r.region, r.ratio));
  return list_of(out);
}
std::string follows_words(const MissingEffort& m) {
  std::vector<std::string> out;
  for (const FollowsTest& f : std::span(m.follows).first(std::min(kMostShown, m.follows.size())))
    out.push_back(fmt::format("{} (r = {:+.2f})", f.quantity, f.correlation));
  return list_of(out);
}

std::string change_words(const MissingEffort& m) {
  std::vector<std::string> out;
  for (const EffortChange& c : std::span(m.changes).first(std::min(kMostShown, m.changes.size())))
    out.push_back(fmt::format("{} of {}: {} to {}", quantity(c.time, "s", 3), c.recording, number(c.before, 2),
                              quantity(c.after, m.unit, 2)));
  if (m.changes.size() > kMostShown) out.push_back(fmt::format("{} more", m.changes.size() - kMostShown));
  return list_of(out);
}

Html bars(std::span<const MissingEffort> missing) {
  BarChart chart;
  chart.title = "Missing effort by joint";
  chart.description = "rms of the effort that the plain model lacks, in units of what the noise alone would show.";
  chart.x_label = "missing effort, times the noise";
  for (const MissingEffort& m : missing) {
    const double ratio = m.rms / m.noise;
    chart.bars.push_back(
        {m.joint, ratio, 0.0, fmt::format("{} ({} of all)", number(ratio, 3), percent(m.share)), beyond_noise(m)});
  }
  return to_svg(chart);
}

/// Its rms between changes, as steps over the time of the trace; empty where it does not change there.
std::pair<std::vector<double>, std::vector<double>> steps(const MissingEffort& m) {
  std::vector<double> x, y;
  for (const EffortChange& c : m.changes) {
    if (c.recording != m.recording || c.time > m.time.back()) continue;
    x.insert(x.end(), {x.empty() ? m.time.front() : x.back(), c.time, c.time});
    y.insert(y.end(), {c.before, c.before, c.after});
  }
  if (!x.empty()) x.push_back(m.time.back()), y.push_back(y.back());
  return {x, y};
}

Html course(const MissingEffort& m) {
  LinePlot plot;
  plot.title = "Missing effort at " + m.joint;
  plot.description = "The effort that the measured motion needs beyond what the plain model gives.";
  plot.recording = m.recording;
  plot.joint = m.joint;
  plot.x_label = "time in " + m.recording;
  plot.x_unit = "s";
  plot.y_label = "missing effort";
  plot.y_unit = m.unit;
  plot.curves.push_back({"missing effort", m.time, m.trace, Ink::before});
  const auto [x, y] = m.time.empty() ? decltype(steps(m)){} : steps(m);
  if (!x.empty()) plot.curves.push_back({"its rms between changes", x, y, Ink::after, 1.4, true});
  plot.band = {-m.noise, m.noise};
  plot.band_label = "noise, rms";
  plot.zero_line = true;
  return zoomable(plot);
}

}  // namespace

Html missing_effort_section(std::span<const MissingEffort> missing) {
  if (missing.empty()) return {};
  Table table({{"joint"},
               {"missing effort", true},
               {"noise", true},
               {"share", true},
               {"chance", true},
               {"larger"},
               {"goes with"},
               {"changes at"}});
  for (const MissingEffort& m : missing)
    table.row({element("code", text(m.joint)), text(quantity(m.rms, m.unit, 3)), text(quantity(m.noise, m.unit, 3)),
               text(percent(m.share)), text(chance_words(m.p_value)), text(region_words(m)), text(follows_words(m)),
               text(change_words(m))},
              beyond_noise(m) && m.share > 0.1);
  Html out = bars(missing);
  if (beyond_noise(missing.front())) out += course(missing.front());
  return out + table.html() +
         paragraph(
             fmt::format(
                 "The effort that the measured motion, low-passed at {:.0f} Hz, needs beyond what the plain model "
                 "gives "
                 "for the same commands, in units of the joint's command. It stands at the joint where something is "
                 "missing, though all joints shake. Each chance is corrected for everything tested in its column; what "
                 "is named has one under 1 in 1,000.",
                 kLocateCutoff),
             "muted small");
}

}  // namespace lacuna
