#include <fmt/format.h>

#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"
#include "scenarios/learned_entry.h"

namespace lacuna {
namespace {

constexpr std::size_t kMostColumns = 5;  ///< of a map, that are drawn as curves

std::string quantity_of(const LearnedLaw::Variable& variable) { return variable_named(variable.name).quantity; }
std::string owner_of(const LearnedLaw& law, const LearnedLaw::Variable& variable) {
  const std::string joint = variable_named(variable.name).joint;
  return joint.empty() ? law.place : joint;
}
std::string what_of(const LearnedLaw& law) {
  switch (law.stage) {
    case Stage::command: return "Learned change of the command";
    case Stage::reading: return "Learned error of the reading";
    default: return "Learned effort";
  }
}

/// One curve of a law: all of it, or at one knot of its second variable.
struct Slice {
  std::string label;
  std::vector<double> at, value, lower, upper;
};
std::vector<Slice> slices_of(const LearnedLaw& law) {
  const std::size_t columns = law.over.size() > 1 ? law.over[1].knots : 1;
  const std::size_t stride = columns > kMostColumns ? (columns + kMostColumns - 1) / kMostColumns : 1;
  std::vector<Slice> out;
  for (std::size_t column = 0; column < columns; column += stride) {
    Slice slice;
    for (std::size_t k = column; k < law.curve.size(); k += columns) {
      const LearnedLaw::Point& p = law.curve[k];
      slice.at.push_back(p.at), slice.value.push_back(p.value);
      slice.lower.push_back(p.lower95), slice.upper.push_back(p.upper95);
    }
    const double beside = slice.at.empty() ? 0.0 : law.curve[column].beside;
    slice.label = columns == 1   ? "learned"
                  : columns == 2 ? (beside < 0.0 ? "moving down" : "moving up")
                                 : fmt::format("{} of {} {} {}", quantity_of(law.over[1]), owner_of(law, law.over[1]),
                                               number(beside, 3), law.over[1].unit);
    out.push_back(std::move(slice));
  }
  return out;
}

Html plot(const LearnedLaw& law) {
  const LearnedLaw::Variable& over = law.over.front();
  const std::vector<Slice> slices = slices_of(law);
  LinePlot out;
  out.title =
      fmt::format("{} at {} over the {} of {}", what_of(law), law.place, quantity_of(over), owner_of(law, over));
  out.description = "The curve with its 95 % band, over what the train recordings have seen; beyond it goes on level.";
  out.x_label = fmt::format("{} of {}", quantity_of(over), owner_of(law, over)), out.x_unit = over.unit;
  out.y_label = what_of(law), out.y_unit = law.unit;
  std::vector<double> seen_at, seen;
  for (const auto& [at, value] : law.cloud) seen_at.push_back(at), seen.push_back(value);
  if (!seen.empty())
    out.curves.push_back(
        {.label = "missing effort", .x = seen_at, .y = seen, .ink = Ink::measured, .width = 2.6, .points = true});
  const bool band = slices.size() <= 2;
  for (const Slice& slice : slices) {
    if (band) {
      const bool first = &slice == &slices.front();
      out.curves.push_back({first ? "95 % band" : "", slice.at, slice.lower, Ink::other, 1.0, true});
      out.curves.push_back({"", slice.at, slice.upper, Ink::other, 1.0, true});
    }
    out.curves.push_back({slice.label, slice.at, slice.value, &slice == &slices.front() ? Ink::after : Ink::before});
  }
  out.zero_line = true;
  return zoomable(out);
}

/// The law over both variables, as a table whose cells are as dark as it is high.
Html map(const LearnedLaw& law) {
  if (law.over.size() < 2 || law.over[1].knots <= 2) return {};
  HeatMap out;
  out.title = what_of(law) + " at " + law.place;
  out.description = "The law over both of its variables: rows are knots of the second, columns of the first.";
  const auto label = [&](const LearnedLaw::Variable& v) { return quantity_of(v) + " of " + owner_of(law, v); };
  out.x_label = label(law.over[0]), out.x_unit = law.over[0].unit, out.y_label = label(law.over[1]);
  out.y_unit = law.over[1].unit, out.unit = law.unit;
  out.x_range = {law.over[0].from, law.over[0].to}, out.y_range = {law.over[1].from, law.over[1].to};
  out.columns = law.over[0].knots;
  for (const LearnedLaw::Point& p : law.curve) out.values.push_back(p.value);
  return to_svg(out);
}

}  // namespace

Html learned_section(std::span<const LearnedLaw> laws) {
  Html out;
  for (const LearnedLaw& law : laws) {
    if (law.over.empty()) continue;
    const std::string of_rest = fmt::format(
        "It takes away {} of the validate recordings' residual energy (log-likelihood {} higher), and has a "
        "log evidence of {} over no such law. Of the joints and variables that could carry it, this one "
        "has a probability of {}.",
        percent(law.heldout_share), number(law.heldout_gain, 3), number(law.evidence, 3), probability(law.probability));
    const std::string more = law.tells_more.empty() ? "" : " " + law.tells_more + ".";
    out += element("div",
                   element("h3", text(fmt::format("{} at {}", what_of(law), law.place))) +
                       paragraph(law.description + ".") + plot(law) + map(law) + paragraph(of_rest + more),
                   "card");
  }
  if (laws.empty()) return out;
  return out + paragraph(
                   "What no effect of the catalogue stands for, learned from what the named ones leave: a smooth "
                   "function of one variable or two, added to an effort, a command or a reading and fitted beside all "
                   "other parameters in full simulation. Points are the missing effort as inverse dynamics has it, "
                   "low-passed. The diagnosed scenario holds the law as an effect of its own (learned_effort, "
                   "learned_command, learned_reading), with which every engine simulates.",
                   "muted small");
}

Html events_section(std::span<const LearnedEvent> events, Marks& marks) {
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
    table.row({text(e.recording), text(to_string(e.role)), text(e.place),
               element("span", text(e.resembles), marks.add(e.place, {{e.recording, e.from, e.to}})),
               text(number(e.from)), text(number(e.to)), text(quantity(e.value, e.unit, 3)),
               text(number(e.evidence, 3))});
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
