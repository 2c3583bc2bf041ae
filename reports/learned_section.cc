#include <fmt/format.h>

#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"

namespace lacuna {
namespace {

Html plot(const LearnedLaw& law) {
  std::vector<double> at, value, lower, upper;
  for (const LearnedLaw::Point& p : law.curve) {
    at.push_back(p.at), value.push_back(p.value);
    lower.push_back(p.lower95), upper.push_back(p.upper95);
  }
  const char* over = law.over == "v" ? "speed" : "position";
  LinePlot out;
  out.title = fmt::format("Learned effort at {} over its {}", law.place, over);
  out.description = "The curve with its 95 % band, over what the train recordings have seen; beyond it goes on level.";
  out.x_label = fmt::format("{} of {}", over, law.place), out.x_unit = law.way_unit;
  out.y_label = "learned effort", out.y_unit = law.unit;
  out.curves = {{"95 % band", at, lower, Ink::other, 1.0, true},
                {"", at, upper, Ink::other, 1.0, true},
                {"learned", at, value, Ink::after}};
  out.zero_line = true;
  return to_svg(out);
}

}  // namespace

Html learned_section(std::span<const LearnedLaw> laws) {
  Html out;
  for (const LearnedLaw& law : laws) {
    const std::string of_rest = fmt::format(
        "It takes away {} of the validate recordings' residual energy (log-likelihood {} higher), and has a "
        "log evidence of {} over no such curve. Of the joints and variables that could carry it, this one "
        "has a probability of {}.",
        percent(law.heldout_share), number(law.heldout_gain, 3), number(law.evidence, 3), probability(law.probability));
    out += element("div",
                   element("h3", text(fmt::format("Learned effort at {}", law.place))) +
                       paragraph(law.description + ".") + plot(law) + paragraph(of_rest),
                   "card");
  }
  if (laws.empty()) return out;
  return out + paragraph(
                   "An effort that no effect of the catalogue stands for, learned from what the named ones leave: a "
                   "smooth function of one variable, fitted beside all other parameters in full simulation. The "
                   "diagnosed scenario holds it as an effect of its own (learned_effort), with which every engine "
                   "simulates.",
                   "muted small");
}

}  // namespace lacuna
