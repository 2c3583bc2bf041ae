#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/study_sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

/// The recording without its folders.
std::string shown(const Excitation& e) {
  const std::string name = e.name.substr(e.name.rfind('/') + 1);
  return e.assumption.empty() ? name : fmt::format("{}, {}", name, e.assumption);
}

/// All excitations as they are, and the first one with what is assumed beyond: the others differ from it alike.
std::vector<Excitation> chosen(std::span<const Excitation> excitations) {
  std::vector<Excitation> out;
  for (const Excitation& e : excitations) {
    if (e.assumption.empty() || e.name == excitations.front().name) out.push_back(e);
  }
  return out;
}

/// Standard error over size from which on a number would say nothing.
constexpr double kUndeterminedError = 10.0;

std::string error_words(const ParameterKnowledge& k) {
  if (!k.moves) return "moves nothing";
  return k.relative_error < kUndeterminedError ? percent(k.relative_error) : "undetermined";
}

Html knowledge_table(std::span<const Excitation> excitations) {
  std::vector<Table::Column> columns{{"parameter"}};
  for (const Excitation& e : excitations) columns.push_back({shown(e), true});
  Table table(columns);
  std::vector<Html> ranks{text("directions determined")};
  for (const Excitation& e : excitations) ranks.push_back(text(fmt::format("{} of {}", e.rank, e.parameters)));
  table.row(ranks, true);
  for (std::size_t i = 0; i < excitations.front().knowledge.size(); ++i) {
    std::vector<Html> cells{element("code", text(excitations.front().knowledge[i].name))};
    for (const Excitation& e : excitations) cells.push_back(text(error_words(e.knowledge[i])));
    table.row(cells);
  }
  for (std::size_t i = 0; i < excitations.front().combinations.size(); ++i) {
    std::vector<Html> cells{text(excitations.front().combinations[i].name)};
    for (const Excitation& e : excitations) cells.push_back(text(percent(e.combination_error[i])));
    table.row(cells, true);
  }
  return table.html();
}

Html ellipse_plot(std::span<const Excitation> excitations, std::size_t index) {
  constexpr Ink kInks[] = {Ink::after, Ink::before, Ink::other, Ink::measured};
  LinePlot plot;
  std::size_t drawn = 0;
  for (const Excitation& e : excitations) {
    if (index >= e.ellipses.size() || !e.assumption.empty() || drawn >= std::size(kInks)) continue;
    const Ellipse& l = e.ellipses[index];
    plot.title = l.x_name + " and " + l.y_name;
    plot.x_label = l.x_name;
    plot.x_unit = l.x_unit;
    plot.y_label = l.y_name;
    plot.y_unit = l.y_unit;
    plot.curves.push_back({shown(e), l.boundary_x, l.boundary_y, kInks[drawn++], 1.6, false});
  }
  if (plot.curves.empty()) return {};
  plot.description = "95 % confidence regions, one an excitation.";
  plot.width = 480;
  plot.height = 320;
  return element("figure", element("h3", text(plot.title)) + zoomable(plot));
}

Html profile_plot(const RivalsRecord& rivals, std::size_t level) {
  constexpr Ink kInks[] = {Ink::after, Ink::before, Ink::other, Ink::measured};
  constexpr int kGrid = 240;
  const double low = 1.0, high = std::log10(static_cast<double>(rivals.budget));
  std::vector<double> x;
  for (int k = 0; k <= kGrid; ++k) x.push_back(low + (high - low) * k / kGrid);
  std::vector<std::vector<double>> shares;
  for (const MethodRecord& m : rivals.methods) {
    shares.emplace_back();
    for (const double at : x) {
      const auto hits = std::count_if(m.reached[level].begin(), m.reached[level].end(),
                                      [&](double e) { return e <= std::pow(10.0, at) * (1.0 + 1e-12); });
      shares.back().push_back(static_cast<double>(hits) / static_cast<double>(m.runs.size()));
    }
  }
  LinePlot plot;
  plot.title = "Success " + success_levels()[level].name;
  plot.description = "Share of the runs that have reached the level, against evaluations.";
  plot.x_label = "log10 of evaluations";
  plot.y_label = "share of runs";
  plot.y_limit = std::pair(0.0, 1.02);
  plot.height = 260;
  for (std::size_t m = 0; m < rivals.methods.size(); ++m)
    plot.curves.push_back(
        {title_of(rivals.methods[m].method), x, shares[m], kInks[m % std::size(kInks)], 2.0, m >= std::size(kInks)});
  return element("figure", element("h3", text(plot.title)) + zoomable(plot));
}

double largest_output(const SearchRun& run) { return run.errors.output_largest; }

std::vector<double> each(const std::vector<SearchRun>& runs, double (*what)(const SearchRun&)) {
  std::vector<double> out;
  for (const SearchRun& run : runs) out.push_back(what(run));
  return out;
}

/// Median of one figure in every cell: conditions down, searchers across.
Html cell_table(const RobustnessRecord& record, double (*what)(const SearchRun&)) {
  std::vector<Table::Column> columns{{"data or bounds"}};
  for (const Searcher searcher : all_searchers()) columns.push_back({title_of(searcher), true});
  Table table(columns);
  for (std::size_t k = 0; k < record.cells.size(); k += all_searchers().size()) {
    std::vector<Html> cells{text(record.cells[k].condition.title)};
    for (std::size_t m = 0; m < all_searchers().size(); ++m)
      cells.push_back(text(quartile_words(quartiles_of(each(record.cells[k + m].runs, what)))));
    table.row(cells);
  }
  return table.html();
}

}  // namespace

Html excitation_section(std::span<const Excitation> excitations) {
  if (excitations.empty()) return {};
  Html out = paragraph(
      "Expected standard error of every parameter over its size, from the sensitivities at the true values (else the "
      "start "
      "values) and the recordings' noise. A direction counts as determined when its standard error is below its own "
      "size.");
  out += knowledge_table(chosen(excitations));
  Html plots;
  for (std::size_t k = 0; k < 3; ++k) plots += ellipse_plot(excitations, k);
  out += element("div", plots, "pair");
  for (const Excitation& e : excitations) {
    if (!e.assumption.empty() || e.undetermined.empty()) continue;
    out += paragraph(shown(e) + " leaves open (each parameter in units of its own size):") + bullets(e.undetermined);
    break;
  }
  return out;
}

Html rivals_section(const Study& study) {
  const RivalsRecord& r = study.rivals;
  if (r.methods.empty()) return {};
  Table table({{"method"},
               {"within 1 %", true},
               {"within 10 %", true},
               {"within twice", true},
               {"evaluations to 1 %, median", true},
               {"final cost, " + study.output_unit, true},
               {"seconds a run", true}});
  for (std::size_t m = 0; m < r.methods.size(); ++m) {
    const MethodRecord& method = r.methods[m];
    table.row({text(title_of(method.method)), text(percent(method.success[0])), text(percent(method.success[1])),
               text(percent(method.success[2])), text(number(quartiles_of(method.reached[0]).median, 3)),
               text(quartile_words(quartiles_of(each(method.runs, final_cost)))),
               text(quartile_words(quartiles_of(each(method.runs, run_seconds)), 2))},
              static_cast<int>(m) == r.recommended);
  }
  Html out = paragraph(r.reason) + table.html();
  for (std::size_t level = 0; level < success_levels().size(); ++level) out += profile_plot(r, level);
  return out +
         paragraph(fmt::format("Every method has {} evaluations a run and the same two-norm to lower; a run has "
                               "succeeded once its cost is within the factor of {}, the lowest that any run found.",
                               r.budget, quantity(r.best, study.output_unit)),
                   "muted small");
}

Html robustness_section(const Study& study) {
  const RobustnessRecord& r = study.robustness;
  if (r.cells.empty()) return {};
  Html out = paragraph("Data " + r.data + (r.planted ? "; the plant is the best fit, since the truth is unknown" : "") +
                       ". Errors are those of the answer against the noise-free motion.");
  out += element("h3", text("Largest error of the motion, " + study.output_unit)) + cell_table(r, largest_output);
  out += element("h3", text("rms error of the motion, " + study.output_unit)) + cell_table(r, output_rms);
  const auto known = each(r.cells.front().runs, combination_index);
  if (std::none_of(known.begin(), known.end(), [](double x) { return std::isnan(x); }))
    out += element("h3", text("Combination error index, %")) + cell_table(r, combination_index);
  return out;
}

Html recovery_section(const Study& study) {
  const RecoveryRecord& r = study.recovery;
  if (r.parameters.empty()) return {};
  Table table({{"parameter"},
               {"true", true},
               {"median found", true},
               {"unit"},
               {"95 % intervals that hold the truth", true},
               {"called determined", true}});
  for (const Recovered& p : r.parameters) {
    int held = 0, named = 0;
    for (std::size_t k = 0; k < p.value.size(); ++k) {
      held += p.lower95[k] <= p.truth && p.truth <= p.upper95[k];
      named += p.identifiable[k];
    }
    table.row({element("code", text(p.name)), text(number(p.truth)), text(number(quartiles_of(p.value).median)),
               text(p.unit), text(fmt::format("{} of {}", held, p.value.size())),
               text(fmt::format("{} of {}", named, p.value.size()))});
  }
  const std::string words =
      r.asked == 0 ? "The genetic algorithm, finished by least squares, calls no parameter determined."
                   : fmt::format(
                         "The genetic algorithm, finished by least squares: of the parameters that it calls "
                         "determined, {} of {} intervals hold the truth.",
                         r.held, r.asked);
  return paragraph(words) + table.html() +
         paragraph("All seeds see the same recordings, so their intervals miss together or not at all.", "muted small");
}

}  // namespace lacuna
