#include <fmt/format.h>

#include <cmath>

#include "reports/json.h"
#include "reports/report.h"
#include "reports/sections.h"
#include "reports/wording.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

std::string fit_sentence(const FitResult& fit) {
  std::size_t known = 0, bound = 0;
  for (const Estimate& e : fit.estimates) known += e.identifiable, bound += e.at_bound;
  std::string out =
      fmt::format("{} parameters identified on {} with {}: the data determine {} of them", fit.estimates.size(),
                  fit.engine, fit.optimizer, known == fit.estimates.size() ? "all" : std::to_string(known));
  if (bound > 0) out += fmt::format(", {} {} at a bound", bound, bound == 1 ? "lies" : "lie");
  return out + ".";
}

/// rms per joint, one column per engine.
Html rms_section(const Scenario& scenario, std::span<const FitResult> fits) {
  std::vector<Table::Column> columns{{"joint"}, {"recordings"}};
  for (const FitResult& fit : fits) columns.push_back({fits.size() > 1 ? fit.engine : "rms", true});
  columns.push_back({"unit"});
  Table table(columns);
  for (const auto& [role, rms] : fits.front().rms) {
    for (const auto& [joint, unused] : rms) {
      std::vector<Html> cells{element("code", text(joint)), text(to_string(role))};
      for (const FitResult& fit : fits) cells.push_back(text(number(entry_of(rms_in(fit, role), joint), 4)));
      cells.push_back(text(residual_unit(scenario, nullptr, joint)));
      table.row(cells);
    }
  }
  if (table.empty()) return {};
  return table.html() +
         paragraph("rms of simulated minus measured. Only the train recordings were fitted.", "muted small");
}

/// Estimates side by side.
Html engines_section(std::span<const FitResult> fits) {
  if (fits.size() < 2) return {};
  std::vector<Table::Column> columns{{"parameter"}, {"unit"}};
  for (const FitResult& fit : fits) columns.push_back({fit.engine, true});
  Table table(columns);
  for (std::size_t i = 0; i < fits.front().estimates.size(); ++i) {
    const Estimate& first = fits.front().estimates[i];
    std::vector<Html> cells{element("code", text(first.name)), text(first.unit)};
    for (const FitResult& fit : fits) cells.push_back(text(i < fit.estimates.size() ? value_of(fit.estimates[i]) : ""));
    table.row(cells);
  }
  std::vector<Html> cells{text("time"), text("")};
  for (const FitResult& fit : fits) cells.push_back(text(duration(fit.seconds)));
  table.row(cells);
  return table.html();
}

Html method_section(const FitResult& fit) {
  Html out = paragraph(
      "The free parameters minimise the difference between simulation and train recordings, weighed by the noise: a "
      "population search where the optimiser has one, then nonlinear least squares. Intervals come from the residual's "
      "Jacobian and from the residual's own correlation in time.");
  if (!(fit.step.step > 0.0)) return out;
  std::string words = fmt::format("Integration step at most {}", quantity(fit.step.step * 1e3, "ms", 3));
  if (std::isfinite(fit.step.error_over_noise))
    words += fmt::format("; measured by halving, it leaves an error of {} times the noise",
                         number(fit.step.error_over_noise, 2));
  return out + paragraph(words + ".");
}

}  // namespace

std::string fit_page(const Scenario& scenario, std::span<const FitResult> fits, const Context& context,
                     std::span<const Picture> pictures, std::span<const Trace> traces) {
  Page page(scenario.name, "Lacuna identification");
  if (!fits.empty()) {
    const FitResult& fit = fits.front();
    page.lead(fit_sentence(fit), "found");
    page.tile("Time", duration(fit.seconds), fmt::format("{} simulations", fit.evaluations));
    page.tile("Directions determined", fmt::format("{} of {}", fit.identifiability.rank, fit.point.size()));
    page.section("Parameters", parameter_section(fit.estimates));
    page.section("Engines side by side", engines_section(fits));
    page.section("Residuals", rms_section(scenario, fits));
    TraceOptions options;
    options.words = {"start values", "identified"};
    page.section("Measured and simulated", trace_section(traces, options));
    page.section("What the data determine", identifiability_section(fit));
    page.section("Population search", convergence_section(fit));
  }
  page.section("Pictures", picture_section(pictures));
  page.section("Notes", bullets(scenario.notes));
  if (!fits.empty()) page.section("Method", method_section(fits.front()));
  page.section("Context", context_section(context));
  return page.str();
}

void write_fit_report(const std::filesystem::path& folder, const Scenario& scenario, std::span<const FitResult> fits,
                      const Context& context, std::span<const Picture> pictures, std::span<const Trace> traces) {
  write_file_atomically(folder / "fit.json", to_json(fits, scenario.name, context));
  write_file_atomically(folder / "report.html", fit_page(scenario, fits, context, pictures, traces));
}

void write_fit_report(const std::filesystem::path& folder, const Scenario& scenario, const FitResult& fit,
                      const Context& context, std::span<const Picture> pictures, std::span<const Trace> traces) {
  write_fit_report(folder, scenario, std::span(&fit, 1), context, pictures, traces);
}

}  // namespace lacuna
