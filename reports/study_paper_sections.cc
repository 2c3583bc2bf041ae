#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/study_sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

const char* tone_of(Judgement verdict) {
  return verdict == Judgement::holds ? "tag fine" : verdict == Judgement::does_not_hold ? "tag warn" : "tag";
}

/// A setting's curve: median, and its quartiles thin and dashed.
struct Band {
  std::string label;
  Ink ink = Ink::after;
  std::vector<double> low, median, high;
};

/// `normalised`: each run from 1 at its first generation to 0 at its last, as the paper's figures 6 and 7.
Band band_of(const SettingRecord& setting, const std::string& label, Ink ink, bool normalised) {
  Band out{label, ink, {}, {}, {}};
  SettingRecord shown = setting;
  for (SearchRun& run : shown.runs) {
    if (!normalised || run.curve.empty()) continue;
    const double first = run.curve.front().best, last = run.curve.back().best;
    for (SearchRun::Entry& entry : run.curve) entry.best = first > last ? (entry.best - last) / (first - last) : 0.0;
  }
  for (const Quartiles& q : shown.curve()) {
    out.low.push_back(q.low);
    out.median.push_back(q.median);
    out.high.push_back(q.high);
  }
  return out;
}

Html curve_plot(const Study& study, const std::string& title, const std::vector<std::pair<std::string, Ink>>& keys,
                bool normalised = false, double last_generation = 0.0) {
  std::vector<Band> bands;
  for (const auto& [key, ink] : keys) {
    const SettingRecord* setting = study.grid.find(key);
    if (setting != nullptr) bands.push_back(band_of(*setting, setting->title, ink, normalised));
  }
  std::size_t longest = 0;
  for (const Band& band : bands) longest = std::max(longest, band.median.size());
  std::vector<double> generation;
  for (std::size_t g = 0; g < longest; ++g) generation.push_back(static_cast<double>(g + 1));
  LinePlot plot;
  plot.title = title;
  plot.description = "Best cost so far by generation: median over the seeds, quartiles dashed.";
  plot.x_label = "generation";
  plot.y_label = normalised ? "cost, normalised" : "best cost (minus fitness)";
  plot.y_unit = normalised ? "" : study.output_unit;
  plot.log_y = !normalised;
  plot.height = 280;
  for (const Band& band : bands) {
    plot.curves.push_back({band.label, generation, band.median, band.ink, 2.0, false});
    plot.curves.push_back({"", generation, band.low, band.ink, 0.8, true});
    plot.curves.push_back({"", generation, band.high, band.ink, 0.8, true});
  }
  if (last_generation > 0.0) plot.x_range = std::pair(1.0, last_generation);
  return element("figure", element("h3", text(title)) + zoomable(plot));
}

std::string median_of(const SettingRecord& setting, double (*what)(const SearchRun&)) {
  return quartile_words(quartiles_of(setting.each(what)));
}

/// Index in the paper's chromosome, or -1.
int paper_index(const std::string& parameter) {
  const auto at = std::find(paper::kParameters.begin(), paper::kParameters.end(), parameter);
  return at == paper::kParameters.end() ? -1 : static_cast<int>(at - paper::kParameters.begin());
}

/// The paper's number in our units: gain from kN m/V, stiffness from N m/deg.
double in_our_units(int index, double value) {
  constexpr double kPerDegree = 57.29577951308232;
  return index == 0 ? 1000.0 * value : index == 2 ? kPerDegree * value : value;
}

/// The row of the paper's that belongs to this preset: table 1's or table 5's truth, told by the truth itself.
const paper::Values* paper_truth(const Study& study) {
  for (const paper::Values& row : paper::kValues) {
    if (std::string(row.row) != "true" || study.truth.size() != paper::kParameters.size()) continue;
    bool same = true;
    for (std::size_t i = 0; i < study.truth.size(); ++i) {
      const int k = paper_index(study.parameters[i]);
      same = same && k >= 0 && std::fabs(in_our_units(k, row.numbers[k]) / study.truth[i] - 1.0) < 0.01;
    }
    if (same) return &row;
  }
  return nullptr;
}

/// Parameter `i` of every run of a setting, as a relative error in percent or as a value.
std::vector<double> parameter_in(const SettingRecord& setting, std::size_t i, double truth) {
  std::vector<double> out;
  for (const SearchRun& run : setting.runs)
    out.push_back(std::isfinite(truth) ? 100.0 * std::fabs(run.point[i] / truth - 1.0) : run.point[i]);
  return out;
}

std::string operators_of(const SettingRecord& s) {
  std::string out = fmt::format("{}, {}", to_string(s.genetic.coding), to_string(s.genetic.crossover));
  if (s.genetic.crossover == Crossover::pointwise) out += fmt::format(" ({} cuts)", s.genetic.cut_points);
  return out + fmt::format(" {}, mutation {} {}, {}", number(s.genetic.crossover_rate), to_string(s.genetic.mutation),
                           number(s.genetic.mutation_rate), to_string(s.genetic.selection));
}

}  // namespace

std::string quartile_words(const Quartiles& q, int digits) {
  if (!std::isfinite(q.median)) return "\u2013";
  return fmt::format("{} ({} to {})", steady(q.median, digits), steady(q.low, digits), steady(q.high, digits));
}

Html conclusions_section(const Study& study) {
  if (study.conclusions.empty()) return {};
  Table table({{"the paper says"}, {"in"}, {"here"}, {"figures: median (quartiles)"}});
  std::vector<std::string> rules;
  for (const Conclusion& c : study.conclusions) {
    table.row({text(c.claim), text(c.source), element("span", text(to_string(c.verdict)), tone_of(c.verdict)),
               text(c.finding)});
    const std::string rule = c.source + ": " + c.rule;
    if (std::find(rules.begin(), rules.end(), rule) == rules.end()) rules.push_back(rule);
  }
  return table.html() + details("How each is judged", bullets(rules)) +
         paragraph(
             fmt::format("{} seeds a setting. The paper ran each once, so its own figures cannot decide.", study.seeds),
             "muted small");
}

Html parameters_section(const Study& study) {
  const SettingRecord* final = study.grid.find("final");
  if (final == nullptr) return {};
  const paper::Values* row = paper_truth(study);
  const bool second = row != nullptr && std::string(row->table) == "table 5";
  std::vector<Table::Column> columns{{"parameter"}, {"unit"}, {"searched"}};
  if (!study.truth.empty()) columns.push_back({"true", true});
  columns.push_back({"start (not used)", true});
  columns.push_back({"final setting: median (quartiles)", true});
  if (second) columns.push_back({"the paper's estimate", true});
  Table table(columns);
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    std::vector<Html> cells{element("code", text(study.parameters[i])), text(study.units[i]),
                            text(fmt::format("{} to {}", number(std::min(study.lower[i], study.upper[i])),
                                             number(std::max(study.lower[i], study.upper[i]))))};
    if (!study.truth.empty()) cells.push_back(text(number(study.truth[i])));
    cells.push_back(text(number(study.start[i])));
    cells.push_back(text(quartile_words(quartiles_of(parameter_in(*final, i, std::nan(""))))));
    if (second) {
      const std::size_t k = paper_index(study.parameters[i]);
      cells.push_back(text(number(in_our_units(static_cast<int>(k), paper::kValues[2].numbers[k]), 3)));
    }
    table.row(cells);
  }
  Html out = table.html();
  if (row != nullptr)
    out += paragraph(
        fmt::format("Truth: the paper's {}, rounded there to 0.1; its units are read as kN m/V, N m s/rad, "
                    "N m/deg and kg. The paper prints no bounds; those searched here hold both of its truths.",
                    row->table),
        "muted small");
  return out;
}

Html curves_section(const Study& study) {
  if (study.grid.settings.empty()) return {};
  return curve_plot(study, "Figure 3: coding", {{"final", Ink::after}, {"coding.integer", Ink::before}}) +
         curve_plot(study, "Figure 4: crossover type",
                    {{"final", Ink::after},
                     {"crossover.uniform_gene", Ink::before},
                     {"crossover.uniform_bit", Ink::other},
                     {"crossover.pointwise_1", Ink::measured}}) +
         curve_plot(study, "Figure 5: crossover rate",
                    {{"final", Ink::after}, {"crossover_rate.0.6", Ink::before}, {"crossover_rate.1.0", Ink::other}}) +
         curve_plot(study, "Figure 6: fitness functions, normalised",
                    {{"final", Ink::after},
                     {"fitness.norm_1", Ink::before},
                     {"fitness.norm_2", Ink::other},
                     {"fitness.norm_inf_relative", Ink::measured}},
                    true) +
         curve_plot(study, "Figure 7: its first generations",
                    {{"final", Ink::after},
                     {"fitness.norm_1", Ink::before},
                     {"fitness.norm_2", Ink::other},
                     {"fitness.norm_inf_relative", Ink::measured}},
                    true, std::max(2.0, 0.2 * study.generations)) +
         paragraph(
             "Medians over the seeds, quartiles dashed. The paper's curves are drawn, not printed as numbers, so "
             "they cannot stand beside these.",
             "muted small");
}

Html settings_section(const Study& study) {
  if (study.grid.settings.empty()) return {};
  Table table({{"setting"},
               {"final cost", true},
               {"output error index, " + study.output_unit, true},
               {"parameter error index, %", true},
               {"combination error index, %", true},
               {"generations to 99 %", true}});
  for (const SettingRecord& s : study.grid.settings)
    table.row({text(s.title), text(median_of(s, final_cost)), text(median_of(s, output_largest)),
               text(median_of(s, parameter_index)), text(median_of(s, combination_index)),
               text(median_of(s, convergence_generation))},
              s.key == "final");
  const SettingRecord& final = study.grid.settings.front();
  Html out =
      table.html() +
      paragraph(fmt::format("Final setting (table 4): {}, population {}, {} generations, fitness {}. Every other "
                            "row changes one thing. Each cell: median (quartiles) over {} seeds. Costs of different "
                            "fitness functions are not comparable; the output error index is: the infinity norm of "
                            "the output error.",
                            operators_of(final), final.genetic.population, final.genetic.generations,
                            to_string(final.fitness), study.seeds),
                "muted small");
  return out;
}

Html fitness_section(const Study& study) {
  if (study.grid.settings.empty()) return {};
  Table table({{"fitness"},
               {"lowest cost", true},
               {"paper", true},
               {"output error index, " + study.output_unit, true},
               {"paper, deg", true},
               {"parameter error index, %", true},
               {"paper, %", true}});
  for (const SettingRecord& s : study.grid.settings) {
    if (s.group != "fitness" && s.group != "final") continue;
    const auto cited = std::find_if(paper::kFitness.begin(), paper::kFitness.end(), [&](const paper::FitnessRow& row) {
      return row.fitness == std::string(to_string(s.fitness));
    });
    const bool known = cited != paper::kFitness.end();
    table.row({element("code", text(to_string(s.fitness))), text(median_of(s, final_cost)),
               text(known ? number(-cited->lowest_fitness) : ""), text(median_of(s, output_largest)),
               text(known ? number(cited->output_error_index) : ""), text(median_of(s, parameter_index)),
               text(known ? number(cited->parameter_error_index) : "")});
  }
  Html out = element("h3", text("Table 3: output and parameter errors")) + table.html();
  if (!study.truth.empty()) {
    std::vector<Table::Column> columns{{"fitness"}};
    for (const std::string& name : study.parameters) columns.push_back({name, true});
    Table errors(columns);
    for (const SettingRecord& s : study.grid.settings) {
      if (s.group != "fitness" && s.group != "final") continue;
      std::vector<Html> cells{element("code", text(to_string(s.fitness)))};
      for (std::size_t i = 0; i < study.parameters.size(); ++i)
        cells.push_back(text(steady(quartiles_of(parameter_in(s, i, study.truth[i])).median, 3)));
      errors.row(cells, true);
      for (const paper::FitnessRow& row : paper::kFitness) {
        if (row.fitness != std::string(to_string(s.fitness))) continue;
        std::vector<Html> theirs{text("the paper's run")};
        for (const std::string& name : study.parameters) {
          const int k = paper_index(name);
          theirs.push_back(text(k < 0 ? "" : number(row.relative_errors[k])));
        }
        errors.row(theirs);
      }
    }
    out += element("h3", text("Table 2: relative errors, percent (median over the seeds)")) + errors.html();
  }
  std::vector<std::string> rankings;
  for (const RankingCheck& r : study.grid.rankings)
    rankings.push_back(
        fmt::format("{}: of {} random parameter sets ranked with and without the denominator, {} neighbours "
                    "change places; {} of {} runs end at the very same parameters.",
                    r.norm, r.points, r.discordant, r.same_answer, r.runs));
  return out + element("h3", text("With and without denominator")) + bullets(rankings) +
         paragraph(
             "The denominator is the norm of the data, one constant for all parameter sets: it can change neither a "
             "ranking nor a roulette that weighs differences of cost. Where runs part nevertheless, rounding decided "
             "a draw.",
             "muted small");
}

Html output_section(const Study& study) {
  const OutputTrace& o = study.grid.output;
  if (o.measured.empty()) return {};
  std::vector<double> error;
  for (std::size_t k = 0; k < o.measured.size(); ++k) error.push_back(o.simulated[k] - o.measured[k]);
  LinePlot plot;
  plot.title = "Figure 8: output with true and estimated parameters";
  plot.description = "Measured position over time with the simulation of the median run laid over it.";
  plot.y_label = "output";
  plot.y_unit = o.unit;
  plot.x_axis_labels = false;
  plot.curves = {{"recorded (true parameters)", o.time, o.measured, Ink::measured, 1.7},
                 {"estimated, median run", o.time, o.simulated, Ink::after, 1.4, true}};
  LinePlot below;
  plot.recording = below.recording = "recorded";
  below.title = "Error of the median run";
  below.x_label = "time";
  below.x_unit = "s";
  below.y_label = "error";
  below.y_unit = o.unit;
  below.height = 170;
  below.zero_line = true;
  below.curves = {{"", o.time, error, Ink::after, 1.2}};
  return element("figure", zoomable(plot) + zoomable(below));
}

Html study_engines_section(const Study& study) {
  if (study.engines.empty()) return {};
  Table table({{"engine"},
               {"final cost, " + study.output_unit, true},
               {"output error index, " + study.output_unit, true},
               {"combination error index, %", true},
               {"evaluations", true},
               {"seconds a run", true}});
  for (const EngineRecord& e : study.engines) {
    if (e.setting.runs.empty()) {
      table.row({element("code", text(e.engine)), text(e.reason), {}, {}, {}, {}});
      continue;
    }
    std::vector<double> evaluations;
    for (const SearchRun& run : e.setting.runs) evaluations.push_back(static_cast<double>(run.evaluations));
    table.row({element("code", text(e.engine)), text(median_of(e.setting, final_cost)),
               text(median_of(e.setting, output_largest)), text(median_of(e.setting, combination_index)),
               text(quartile_words(quartiles_of(evaluations))), text(median_of(e.setting, run_seconds))});
  }
  const GeneticOptions& g = study.engines.front().setting.genetic;
  return table.html() +
         paragraph(fmt::format("The final setting on every engine, population {}, {} generations instead of {}: what "
                               "engines without lanes afford. Median (quartiles) over {} seeds.",
                               g.population, g.generations, study.generations, study.seeds),
                   "muted small");
}

}  // namespace lacuna
