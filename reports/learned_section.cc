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

Html events_section(std::span<const LearnedEvent> events) {
  if (events.empty()) return {};
  Table table({{"recording"},
               {"role"},
               {"joint"},
               {"event"},
               {"from, s", true},
               {"to, s", true},
               {"size", true},
               {"log evidence", true}});
  for (const LearnedEvent& e : events)
    table.row({text(e.recording), text(to_string(e.role)), text(e.place), text(e.resembles), text(number(e.from)),
               text(number(e.to)), text(quantity(e.value, e.unit, 3)), text(number(e.evidence, 3))});
  return table.html() +
         paragraph(
             "What happened once, in one recording, and is no part of the machine: an effort on a joint beside its "
             "actuator's (its largest value; of one shorter than two samples only size times duration is determined), "
             "a "
             "command that was lost (nothing arrived) or repeated (the one before stayed), a position read beside the "
             "true one. The parameters are fitted with the events of the train recordings in the simulation, and the "
             "diagnosed scenario holds those of the train and validate recordings. What happened in a test recording "
             "is "
             "said here and goes into no other figure.",
             "muted small");
}

}  // namespace lacuna
