#include <fmt/format.h>

#include <cmath>

#include "reports/sections.h"
#include "reports/study.h"
#include "reports/study_sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

std::vector<Design> designs_of(const DesignResult& result) {
  std::vector<Design> out{result.best, result.step};
  out.insert(out.end(), result.recordings.begin(), result.recordings.end());
  return out;
}

Html command_section(const DesignResult& result, const std::vector<std::string>& joints,
                     const std::vector<std::string>& units) {
  Html out;
  for (std::size_t j = 0; j < result.best.commands.value.size(); ++j) {
    if (!(result.best.peak_command[j] > 0.0)) continue;
    LinePlot plot;
    plot.title = joints[j];
    plot.description = "The designed command over time, with the step it is compared to.";
    plot.recording = "designed";
    plot.joint = joints[j];
    plot.x_label = "time";
    plot.x_unit = "s";
    plot.y_label = "command";
    plot.y_unit = units[j];
    plot.curves = {{"step", result.step.commands.time, result.step.commands.value[j], Ink::before, 1.2, true},
                   {"designed", result.best.commands.time, result.best.commands.value[j], Ink::after, 1.6}};
    out += element("figure", element("h3", text(joints[j])) + zoomable(plot));
  }
  return out;
}

Html motion_section(const DesignResult& result, const std::vector<std::string>& joints,
                    const std::vector<std::string>& units) {
  Table table({{"motion"},
               {"joint"},
               {"peak command", true},
               {"lowest, rad or m", true},
               {"highest", true},
               {"fastest, 1/s", true}});
  for (const Design& d : designs_of(result)) {
    for (std::size_t j = 0; j < joints.size(); ++j)
      table.row({text(d.name), element("code", text(joints[j])), text(quantity(d.peak_command[j], units[j], 3)),
                 text(number(d.lowest[j], 3)), text(number(d.highest[j], 3)), text(number(d.peak_speed[j], 3))});
  }
  return table.html();
}

Html information_section(const DesignResult& result) {
  Table table({{"motion"}, {"log det of information", true}, {"directions determined", true}});
  for (const Design& d : designs_of(result))
    table.row({text(d.name), text(number(d.log_det, 5)),
               text(fmt::format("{} of {}", d.excitation.rank, d.excitation.parameters))});
  return table.html() +
         paragraph(
             "Information: the whitened sensitivities' normal matrix, every parameter counted in the deviation of its "
             "bounds, plus one (Bayesian D-optimality): what the bounds tell stands for what no motion can.",
             "muted small");
}

}  // namespace

std::string excitation_page(const DesignResult& result, const std::string& scenario,
                            const std::vector<std::string>& joints, const std::vector<std::string>& units,
                            const Context& context) {
  Page page(scenario, "Lacuna excitation");
  const double gain = result.best.log_det - result.step.log_det;
  page.lead(
      fmt::format("The designed motion determines {} of {} directions of the parameters, a step {}; each parameter's "
                  "uncertainty shrinks {}-fold on geometric average against the step.",
                  result.best.excitation.rank, result.best.excitation.parameters, result.step.excitation.rank,
                  number(std::exp(0.5 * gain / result.best.excitation.parameters), 3)),
      gain > 0.0 ? "good" : "open");
  page.tile("Motions looked at", std::to_string(result.evaluations));
  page.section("Commands", command_section(result, joints, units));
  page.section("Information", information_section(result));
  std::vector<Excitation> excitations;
  for (const Design& d : designs_of(result)) excitations.push_back(d.excitation);
  page.section("Expected standard errors", excitation_section(excitations));
  page.section("Motion", motion_section(result, joints, units));
  page.section("Context", context_section(context));
  return page.str();
}

}  // namespace lacuna
