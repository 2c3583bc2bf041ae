#include <fmt/format.h>

#include "reports/sections.h"
#include "reports/wording.h"

namespace lacuna {
namespace {

const char* title_of(ChainPart part) {
  switch (part) {
    case ChainPart::command_to_flow: return "command to flow";
    case ChainPart::supply: return "supply";
    case ChainPart::flow_to_pressure: return "flow to pressure";
    case ChainPart::pressure_to_motion: return "pressure to motion";
  }
  return "";
}
const char* part_of(ChainPart part) {
  switch (part) {
    case ChainPart::command_to_flow: return "valve";
    case ChainPart::supply: return "shared supply";
    case ChainPart::flow_to_pressure: return "chambers";
    case ChainPart::pressure_to_motion: return "piston and links";
  }
  return "";
}

bool judged(const PartFit& part) { return part.why_not.empty(); }
std::string times(double rms, const PartFit& part) { return number(rms / part.noise, 2); }

/// "12.1 times the noise, 1.3 with what was found".
std::string figures(const PartFit& part, bool two) {
  std::string out = times(part.before, part) + " times the noise";
  if (two) out += ", " + times(part.after, part) + " with what was found";
  return out;
}

std::string color_of(const PartFit& part) {
  if (!judged(part)) return "var(--muted,#5b626d)";
  return part.fails() ? "var(--before,#d4571e)" : "var(--good,#1b7f46)";
}

constexpr double kHigh = 40.0, kWide = 150.0, kTop = 14.0, kBelow = 100.0;  // px, of the boxes

std::string label(double x, double y, const std::string& words, double opacity, int size) {
  return fmt::format(
      "<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\" font-size=\"{}\" fill=\"currentColor\" "
      "fill-opacity=\"{}\">{}</text>\n",
      x, y, size, opacity, escape(words));
}

/// One part as a box about x, its figures under it.
std::string box(const PartFit& part, double x, double y, bool two) {
  const std::string color = color_of(part);
  std::string out = fmt::format(
      "<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"7\" style=\"fill:{};stroke:{}\" "
      "fill-opacity=\".13\" stroke-width=\"1.5\"{}/>\n",
      x - 0.5 * kWide, y, kWide, kHigh, color, color, judged(part) ? "" : " stroke-dasharray=\"5 4\"");
  out += label(x, y + 25.0, part_of(part.part), 1.0, 14);
  std::string under = "not judged";
  if (judged(part))
    under = two ? times(part.before, part) + " \u2192 " + times(part.after, part) : times(part.before, part);
  return out + label(x, y + kHigh + 16.0, under, 0.8, 13);
}

std::string arrow(double x1, double y1, double x2, double y2) {
  return fmt::format(
      "<line x1=\"{:.0f}\" y1=\"{:.0f}\" x2=\"{:.0f}\" y2=\"{:.0f}\" stroke=\"currentColor\" stroke-opacity=\".55\" "
      "stroke-width=\"1.5\" marker-end=\"url(#chain-head)\"/>\n",
      x1, y1, x2, y2);
}

/// The arrows' head, once a page.
constexpr char kArrowHead[] =
    "<defs><marker id=\"chain-head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" "
    "orient=\"auto\"><path d=\"M0 0 8 4 0 8z\" fill=\"currentColor\" fill-opacity=\".55\"/></marker></defs>\n";

/// The chain as a row of boxes between what is measured, the supply under its valve.
Html drawing(const JointChain& chain, bool two, bool first) {
  static constexpr std::array<const char*, 4> kSignals{"command", "flow", "pressure", "motion"};
  static constexpr std::array<ChainPart, 3> kRow{ChainPart::command_to_flow, ChainPart::flow_to_pressure,
                                                 ChainPart::pressure_to_motion};
  constexpr double kFirst = 50.0, kPitch = 280.0;
  const double middle = kTop + 0.5 * kHigh;
  std::string out =
      "<svg class=\"chart\" viewBox=\"0 0 960 164\" role=\"img\"><title>" + escape("The chain of " + chain.joint) +
      "</title><desc>Each part between two measured signals, with its mismatch in units of the noise.</desc>\n";

  if (first) out += kArrowHead;
  for (std::size_t k = 0; k < kSignals.size(); ++k) {
    const double x = kFirst + kPitch * static_cast<double>(k);
    out += label(x, middle + 5.0, kSignals[k], 0.9, 14);
    if (k == kRow.size()) break;
    const double part = x + 0.5 * kPitch;
    out += arrow(x + 36.0, middle, part - 0.5 * kWide - 3.0, middle);
    out += arrow(part + 0.5 * kWide + 3.0, middle, x + kPitch - 36.0, middle);
    out += box(chain.parts[static_cast<std::size_t>(kRow[k])], part, kTop, two);
  }
  const double valve = kFirst + 0.5 * kPitch;
  out += arrow(valve - 0.36 * kWide, kBelow - 2.0, valve - 0.36 * kWide, kTop + kHigh + 3.0);
  out += box(chain.parts[static_cast<std::size_t>(ChainPart::supply)], valve, kBelow, two);
  return {out + "</svg>\n"};
}

std::string words_of(const JointChain& chain, bool two) {
  std::vector<std::string> failing, holding, open;
  for (const PartFit& part : chain.parts) {
    const std::string title = title_of(part.part);
    if (!judged(part)) {
      open.push_back(title + " (" + part.why_not + ")");
    } else if (part.fails()) {
      failing.push_back(title + " (" + figures(part, two) + ")");
    } else {
      const bool of_the_valve = part.expected_before > part.noise && part.before > part.noise;
      holding.push_back(title + " (" + times(part.before, part) +
                        (of_the_valve ? ", no more than the valve alone" : "") + ")");
    }
  }
  std::string out =
      failing.empty() ? "No part fails beyond the noise." : "The plain model fails at: " + list_of(failing) + ".";
  if (!holding.empty()) out += " It holds, in units of the noise, at: " + list_of(holding) + ".";
  if (!open.empty()) out += " Not judged: " + list_of(open) + ".";
  return out;
}

Html figures_table(std::span<const JointChain> chains, bool two) {
  std::vector<Table::Column> columns{{"joint"}, {"part"}, {"plain model", true}};
  if (two) columns.push_back({"diagnosed", true});
  for (const char* title : {"noise", "signal"}) columns.push_back({title, true});
  columns.push_back({"unit"});
  columns.push_back({"samples", true});
  Table table(columns);
  for (const JointChain& chain : chains)
    for (const PartFit& part : chain.parts) {
      if (!judged(part)) continue;
      std::vector<Html> row{element("code", text(chain.joint)), text(title_of(part.part)),
                            text(number(part.before, 3))};
      if (two) row.push_back(text(number(part.after, 3)));
      row.insert(row.end(), {text(number(part.noise, 3)), text(number(part.signal, 3)), text(part.unit),
                             text(fmt::format("{:.0f}", part.samples))});
      table.row(std::move(row), part.fails());
    }
  return table.empty() ? Html{} : table.html();
}

constexpr char kWhatIsCompared[] =
    "Measured pressures cut the chain from command to motion, and each part is judged by what was measured before and "
    "behind it, on the recordings that were not fitted, low-passed at {:.0f} Hz; numbers under a part are its mismatch "
    "in units of the noise{}. Command to flow: what the valve's equation lets through, against what the piston's "
    "motion and the oil's compression took, as the joint's speed, while no other joint is commanded; supply: the same "
    "while others are. Flow to pressure: the same behind a closed valve, where only leaks and compression are left. "
    "Pressure to motion: the piston's force against the effort that the motion needs. A joint whose actuator has no "
    "areas is judged by its simulated speed, and the areas that turn its pressures into an effort are fitted to the "
    "train recordings. A part fails where its mismatch has a chance under 1 in 1,000 from noise alone, corrected for "
    "all parts, and is over 1.5 times the noise; a supply where it is that much over what the valve leaves by itself "
    "at that speed.";

}  // namespace

Html chain_section(std::span<const JointChain> chains, bool two) {
  if (chains.empty()) return {};
  Html out;
  for (const JointChain& chain : chains) {
    out += element("h3", element("code", text(chain.joint)));
    out += paragraph(words_of(chain, two));
    out += drawing(chain, two, &chain == chains.data());
  }
  const char* both = two ? ", of the plain model and of the diagnosed one" : "";
  return out + figures_table(chains, two) + paragraph(fmt::format(kWhatIsCompared, kLocateCutoff, both), "muted small");
}

}  // namespace lacuna
