#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/comparison.h"
#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"
#include "scenarios/files.h"
#include "compare/runner.h"

namespace lacuna {
namespace {

constexpr Ink kInks[] = {Ink::after, Ink::before, Ink::other, Ink::measured};

Html code(const std::string& any) { return element("code", text(any)); }

Html tick(bool yes) { return element("span", text(yes ? "yes" : "no"), yes ? "tag fine" : "tag warn"); }

std::string method_title(const MethodResult& method) { return method.native ? method.name : method.name + " (common)"; }

/// "612", with the half width of its quartiles: "612 ± 8".
std::string timing(const Timing& t, double unit = 1.0) {
  if (std::isnan(t.median)) return "\u2013";
  return fmt::format("{} \u00b1 {}", steady(t.median * unit), number(0.5 * (t.high - t.low) * unit, 2));
}

/// A difference of two timings; where it drowns in their scatter, by what it is bounded.
std::string difference(const Timing& t, const Timing& without) {
  const double scatter = 0.5 * std::max(t.high - t.low, without.high - without.low);
  return t.median > scatter || !std::isfinite(t.median) ? timing(t)
                                                        : "under " + number(std::max(scatter, std::fabs(t.median)), 3);
}

std::string bytes(double value) {
  if (!std::isfinite(value)) return "\u2013";
  return value < 1e6 ? number(value / 1e3, 3) + " kB" : number(value / 1e6, 3) + " MB";
}

Html verdict_section(const std::vector<Recommendation>& all) {
  if (all.empty()) return {};
  std::vector<Table::Column> columns{{"for"}, {"choose"}};
  for (const auto& [engine, unused] : all.front().figures) columns.push_back({engine, true});
  columns.push_back({"figures are"});
  Table table(columns);
  for (const Recommendation& verdict : all) {
    std::vector<Html> cells{text(verdict.need), element("strong", text(list_of(verdict.best)))};
    for (const auto& [engine, value] : verdict.figures) cells.push_back(text(number(value, 3)));
    cells.push_back(text(verdict.measure) +
                    (verdict.remark.empty() ? Html{} : paragraph(verdict.remark, "muted small")));
    table.row(cells);
  }
  return table.html() +
         paragraph(
             "Engines within 10 % of the best are named with it. Figures are taken over those scenarios that every "
             "engine asked for could run.",
             "muted small");
}

Html baseline_section(const Baseline& baseline) {
  if (baseline.empty()) return {};
  const std::string origin =
      fmt::format("Against {} of {} (commit {}): {} figures compared, {} changed beyond noise.", baseline.file,
                  baseline.date, baseline.commit, baseline.compared, baseline.changes.size());
  Table table({{"scenario"}, {"engine"}, {"quantity"}, {"before", true}, {"now", true}, {"factor", true}, {""}});
  for (const Change& change : baseline.changes)
    table.row({code(change.scenario), text(change.engine), text(change.quantity), text(number(change.before, 4)),
               text(number(change.after, 4)), text(number(change.after / change.before, 3)),
               element("span", text(change.better ? "better" : "worse"), change.better ? "tag fine" : "tag warn")});
  return paragraph(origin) + (table.empty() ? Html{} : table.html()) +
         paragraph(
             "Timings are in units of Featherstone's evaluation in the same run. Beyond noise: a timing that moved by "
             "over 10 % and three times both runs' quartile spread, an error that moved by over 10 % and is above "
             "rounding.",
             "muted small");
}

/// What is asked of every engine, by the method that is the same for all.
Html agreement_table(const ScenarioComparison& scenario) {
  Table table({{"engine"},
               {"acceleration difference", true},
               {"acceleration error", true},
               {"pose difference", true},
               {"trajectory error", true},
               {"energy drift", true},
               {"ns per step", true},
               {"real-time factor", true}});
  Html refused;
  for (const EngineComparison& engine : scenario.engines) {
    if (!engine.available) {
      refused += paragraph(engine.engine + ": " + engine.reason);
      continue;
    }
    const MethodResult& common = engine.method(kCommonMethod);
    table.row({text(engine.engine), text(number(engine.acceleration_difference.value, 2)),
               text(number(engine.acceleration_error.value, 2)), text(number(engine.pose_difference.value, 2)),
               text(number(common.trajectory_error, 3)), text(number(common.energy_drift, 2)),
               text(timing(common.ns_per_step)), text(number(common.realtime_factor, 3))});
  }
  return table.html() + refused;
}

Html cost_table(const ScenarioComparison& scenario) {
  Table table(
      {{"engine"}, {"evaluation, ns", true}, {"change of a body, ns", true}, {"build, us", true}, {"memory", true}});
  for (const EngineComparison& engine : scenario.engines) {
    if (!engine.available) continue;
    table.row({text(engine.engine), text(timing(engine.forward_ns)),
               text(difference(engine.set_inertial_ns, engine.forward_ns)), text(timing(engine.build_us)),
               text(bytes(engine.memory_bytes))});
  }
  return element("h3", text("Costs")) + table.html();
}

Html method_table(const ScenarioComparison& scenario) {
  Table table({{"engine"},
               {"integrator"},
               {"order", true},
               {"order driven", true},
               {"trajectory error", true},
               {"worst at"},
               {"energy drift", true},
               {"momentum drift", true},
               {"ns per step", true},
               {"longest stable step", true},
               {"same bits"}});
  std::vector<std::string> left_out;
  for (const EngineComparison& engine : scenario.engines) {
    for (const MethodResult& method : engine.methods) {
      if (!method.not_run.empty())
        left_out.push_back(fmt::format("{}, {}: {}", engine.engine, method.name, method.not_run));
      if (!method.not_run.empty() || method.adaptive()) continue;
      const std::string stable = quantity(1e3 * method.largest_stable_step, "ms", 3);
      table.row({text(engine.engine), text(method_title(method)), text(number(method.order_free, 3)),
                 text(number(method.order, 3)), text(number(method.trajectory_error, 3)),
                 text(fmt::format("{}, {} s", method.trajectory_worst_joint, number(method.trajectory_worst_time, 3))),
                 text(number(method.energy_drift, 2)), text(number(method.momentum_drift, 2)),
                 text(timing(method.ns_per_step)), text(method.stable_at_longest ? "\u2265 " + stable : stable),
                 tick(method.repeats && method.restores)});
    }
  }
  return element("h3", text("Integrators")) + table.html() + bullets(left_out);
}

Html drift_table(const ScenarioComparison& scenario) {
  Table table({{"engine"}, {"joints kept by"}, {"apart, m", true}, {"axes apart, rad", true}});
  for (const EngineComparison& engine : scenario.engines) {
    for (const JointDrift& drift : engine.joint_drift)
      table.row(
          {text(engine.engine), text(drift.settings), text(number(drift.distance, 3)), text(number(drift.angle, 3))});
  }
  if (table.empty()) return {};
  return element("h3", text("Joints that come apart")) + table.html() +
         paragraph(
             "Free motion at the comparison's step, bodies left to themselves. Engines that are not listed keep joint "
             "angles: their joints cannot come apart.",
             "muted small");
}

/// The common method dashed, the engine's default integrator in full.
Html error_plot(const ScenarioComparison& scenario) {
  LinePlot plot;
  plot.title = scenario.name + ": error over time";
  plot.description = "Position error against the referee over time, worst joint, logarithmic.";
  plot.x_label = "time";
  plot.x_unit = "s";
  plot.y_label = "error";
  plot.y_unit = "rad (m)";
  plot.log_y = true;
  plot.height = 280;
  for (std::size_t e = 0; e < scenario.engines.size(); ++e) {
    bool native_shown = false;
    for (const MethodResult& method : scenario.engines[e].methods) {
      const bool shown = !method.native || !native_shown;
      if (method.time.empty() || !shown) continue;
      native_shown = native_shown || method.native;
      plot.curves.push_back({scenario.engines[e].engine + ", " + method_title(method), method.time, method.error,
                             kInks[e % std::size(kInks)], 1.4, !method.native});
    }
  }
  return plot.curves.empty() ? Html{} : element("figure", zoomable(plot));
}

struct PointCurve {
  std::string label;
  std::vector<double> x, y;
};

/// Error over `x`, one figure an engine, one curve a method.
template <class X>
Html method_plot(const EngineComparison& engine, const std::string& title, const std::string& label,
                 const std::string& unit, const X& x) {
  std::vector<PointCurve> curves;
  for (const MethodResult& method : engine.methods) {
    PointCurve curve{method_title(method), {}, {}};
    for (const WorkPoint& point : method.points) {
      curve.x.push_back(x(point));
      curve.y.push_back(std::isfinite(point.error) ? point.error : std::nan(""));
    }
    const bool any = std::any_of(curve.x.begin(), curve.x.end(), [](double value) { return std::isfinite(value); });
    if (any) curves.push_back(std::move(curve));
  }
  if (curves.empty()) return {};
  LinePlot plot;
  plot.title = title + ", " + engine.engine;
  plot.description = "Position error against the referee over " + label + ", both logarithmic.";
  plot.x_label = label;
  plot.x_unit = unit;
  plot.y_label = "error";
  plot.y_unit = "rad (m)";
  plot.log_x = plot.log_y = true;
  plot.width = 500;
  plot.height = 300;
  for (std::size_t c = 0; c < curves.size(); ++c)
    plot.curves.push_back({curves[c].label, curves[c].x, curves[c].y, kInks[c % std::size(kInks)], 1.5, c >= 4});
  return element("figure", element("h3", text(engine.engine)) + zoomable(plot));
}

Html work_section(const ScenarioComparison& scenario) {
  Html work, steps;
  for (const EngineComparison& engine : scenario.engines) {
    work += method_plot(engine, scenario.name + ": work and precision", "computing time a second of motion", "s",
                        [](const WorkPoint& point) { return point.cpu_per_second; });
    steps += method_plot(engine, scenario.name + ": error against step", "step", "s",
                         [](const WorkPoint& point) { return point.step; });
  }
  if (work.markup.empty()) return {};
  return element("h3", text("Work and precision")) + element("div", work, "pair") +
         details("Error against step", element("div", steps, "pair"));
}

Html pair_section(const PairFits& fits) {
  if (!fits.not_run.empty()) return {};
  std::vector<Table::Column> columns{{"data from"}, {"identified on"}};
  for (const auto& [name, value] : fits.truth)
    columns.push_back({fmt::format("{} ({})", name, number(value, 4)), true});
  for (const char* title : {"largest error", "output rms", "simulations", "time"}) columns.push_back({title, true});
  Table table(columns);
  for (const PairFit& pair : fits.pairs) {
    std::vector<Html> cells{text(pair.data_engine), text(pair.engine)};
    for (const auto& [name, value] : pair.values) cells.push_back(text(number(value, 7)));
    cells.push_back(text(number(pair.parameter_error, 2)));
    cells.push_back(text(number(pair.output_rms, 2)));
    cells.push_back(text(std::to_string(pair.evaluations)));
    cells.push_back(text(duration(pair.seconds)));
    table.row(cells, pair.data_engine == pair.engine);
  }
  return element("h3", text("Identification, all pairs")) +
         paragraph(
             fmt::format("{}. Data are each engine's own: of its default integrator at the comparison's step, "
                         "efforts held over it, noise-free. Every engine identifies by the common method, so what "
                         "the parameters lack is what the data's integrator did.",
                         fits.budget)) +
         table.html() +
         paragraph(
             fmt::format("Residuals are weighed by {} rad (m), about what a 12-bit transducer adds; output rms is in "
                         "rad (m). The true values stand in the heads.",
                         number(fits.weight)),
             "muted small");
}

std::string referee_words(const ScenarioComparison& scenario) {
  const RefereeRecord& r = scenario.referee;
  return fmt::format(
      "Referee: {}, tolerance {} a step; it differs from a run of a hundred times the tolerance by at most {} rad (m) "
      "until {} s.",
      r.method, number(r.tolerance), number(r.error, 2), number(r.trusted_until, 3));
}

Html scenario_section(const ScenarioComparison& scenario) {
  Html out = paragraph(fmt::format(
      "{} joints; {}. Common figures at a step of {} over the whole motion; steps are varied "
      "over its first {}.",
      scenario.dof, scenario.motion, quantity(1e3 * scenario.step, "ms", 3), quantity(scenario.window, "s", 3)));
  out += bullets(scenario.notes);
  out += agreement_table(scenario) + cost_table(scenario) + method_table(scenario) + error_plot(scenario) +
         work_section(scenario) + drift_table(scenario) + pair_section(scenario.identification);
  return out + paragraph(referee_words(scenario), "muted small");
}

/// Cost of an evaluation by number of joints, over all scenarios.
Html growth_section(const Comparison& comparison) {
  std::vector<const ScenarioComparison*> sorted;
  for (const ScenarioComparison& scenario : comparison.scenarios) sorted.push_back(&scenario);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) { return a->dof < b->dof; });
  if (sorted.size() < 3 || sorted.front()->dof == sorted.back()->dof) return {};
  std::vector<PointCurve> curves;
  Table table({{"scenario"}, {"joints", true}, {"engine"}, {"ns per evaluation", true}, {"per joint", true}});
  for (const EngineInfo& info : comparison.engines) {
    PointCurve curve{info.name, {}, {}};
    for (const ScenarioComparison* scenario : sorted) {
      const EngineComparison* engine = scenario->find(info.name);
      if (engine == nullptr || !engine->available) continue;
      curve.x.push_back(scenario->dof);
      curve.y.push_back(engine->forward_ns.median);
      table.row({code(scenario->name), text(std::to_string(scenario->dof)), text(info.name),
                 text(timing(engine->forward_ns)), text(number(engine->forward_ns.median / scenario->dof, 3))});
    }
    if (!curve.x.empty()) curves.push_back(std::move(curve));
  }
  LinePlot plot;
  plot.title = "Cost against joints";
  plot.description = "Nanoseconds of one acceleration over the number of joints, both logarithmic.";
  plot.x_label = "joints";
  plot.y_label = "an evaluation";
  plot.y_unit = "ns";
  plot.log_x = plot.log_y = true;
  plot.height = 300;
  for (std::size_t c = 0; c < curves.size(); ++c)
    plot.curves.push_back({curves[c].label, curves[c].x, curves[c].y, kInks[c % std::size(kInks)], 1.6});
  return element("figure", zoomable(plot)) + details("Figures", table.html());
}

Html models_section(const Comparison& comparison) {
  std::vector<Table::Column> columns{{"quantity"}};
  std::vector<const EngineInfo*> shown;
  for (const EngineInfo& info : comparison.engines) {
    if (info.own_models.empty()) continue;
    shown.push_back(&info);
    columns.push_back({info.name});
  }
  if (shown.empty()) return {};
  Table table(columns);
  for (const OwnModel& model : shown.front()->own_models) {
    std::vector<Html> cells{text(model.quantity)};
    for (const EngineInfo* info : shown) {
      const auto at = std::find_if(info->own_models.begin(), info->own_models.end(),
                                   [&](const OwnModel& other) { return other.quantity == model.quantity; });
      cells.push_back(text(at == info->own_models.end() ? "" : at->words));
    }
    table.row(cells);
  }
  return table.html() +
         paragraph(
             "All of it is off in every comparison, and contacts with it: actuators, friction, damping and stops are "
             "the "
             "scenario's own, computed by one code for all engines, so that only rigid-body dynamics and integrators "
             "differ. A user of MuJoCo's own friction loss or of ODE's stops gets another model than is compared "
             "here.");
}

Html method_section() {
  return bullets(
             {"Acceleration difference: |a - a'| / |a'| over 1,024 random states, a' Featherstone's in double "
              "precision; "
              "error: the same with a' in extended precision. Angles within limits or all round, speeds within 2 rad/s "
              "(m/s), efforts within 20 N m (N).",
              "Trajectory error: largest difference of any joint's position from the referee's at the samples, "
              "radians, "
              "for sliding joints metres.",
              "Common methods carry every engine alike: Kutta's fourth-order steps with dry friction cut exactly "
              "(rk4), "
              "and Dormand and Prince's pair with step control (dopri5). Own integrators hold the efforts over a step, "
              "as "
              "a controller does: on a driven joint this alone makes them first order. The column `order` is of free "
              "motion, where nothing is held; `order driven` of the scenario's motion.",
              "Same bits: a second run, and a run resumed from a saved (q, v) on a fresh build, in free motion.",
              "Energy drift: largest change over the largest kinetic energy in free motion. Momentum drift: the root "
              "joint's momentum in free motion without gravity, over the largest sum of its parts. Both are read off "
              "by "
              "Featherstone's energy and mass matrix, whoever made the motion.",
              "Longest stable step: of the halvings of the sample spacing, the longest from which on all shorter ones "
              "stay finite and no joint becomes ten times as fast as the reference's fastest. Where commands are held "
              "from sample to sample none longer than that spacing is tried.",
              "Timings are CPU time of one thread, engines and integrators in turn, nine rounds (three of slow runs), "
              "medians with half the distance of the quartiles. The computing time of a point of work and precision is "
              "the "
              "number of its steps (with step control: evaluations) times what one costs. Every step goes through "
              "Lacuna's interface: what it "
              "copies in and out is in the figure, and Simbody's integrators are begun anew each step."}) +
         paragraph(
             "What this does not prove: nothing here has contacts, loops or free-floating bases, where these engines "
             "differ most. A small error against the referee says that the equations are solved, not that they are the "
             "machine's.");
}

/// Contact sheets, over the full width.
Html sheet_section(std::span<const Picture> pictures) {
  Html out;
  for (const Picture& sheet : pictures)
    out += element("figure", picture(sheet.png, sheet.title) + element("figcaption", text(sheet.title)));
  return out;
}

std::string lead_of(const std::vector<Recommendation>& all) {
  std::vector<std::string> words;
  for (const Recommendation& verdict : all) {
    if (words.size() == 4) break;
    words.push_back(fmt::format("{}: {}", verdict.need, list_of(verdict.best)));
  }
  std::string out;
  for (const std::string& part : words) out += (out.empty() ? "" : "; ") + part;
  return out.empty() ? "Nothing could be compared." : "Choose for " + out + ".";
}

}  // namespace

std::string comparison_page(const Comparison& comparison, const Baseline& baseline, const Context& context,
                            std::span<const Picture> pictures) {
  const bool one = comparison.scenarios.size() == 1;
  const std::vector<Recommendation> all = recommendations(comparison);
  Page page(one ? comparison.scenarios.front().name : fmt::format("{} scenarios", comparison.scenarios.size()),
            "Lacuna engine comparison");
  page.lead(lead_of(all), "found");
  double worst = 0.0;
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    for (const EngineComparison& engine : scenario.engines)
      if (engine.available) worst = std::max(worst, engine.acceleration_difference.value);
  }
  page.tile("Largest acceleration difference", number(worst, 2), "relative, against Featherstone");
  page.tile("Time", duration(comparison.seconds), fmt::format("{} threads", context.threads));
  page.section("Which engine for which need", verdict_section(all));
  page.section("Since the older comparison", baseline_section(baseline));
  for (const ScenarioComparison& scenario : comparison.scenarios)
    page.section(scenario.name, scenario_section(scenario));
  page.section("Cost against joints", growth_section(comparison));
  page.section("Poses", sheet_section(pictures));
  page.section("What engines model differently", models_section(comparison));
  page.section("Method and limits", method_section());
  page.section("Context", context_section(context));
  return page.str();
}

void write_comparison_report(const std::filesystem::path& folder, const Comparison& comparison,
                             const Baseline& baseline, const Context& context, std::span<const Picture> pictures) {
  write_file_atomically(folder / "compare.json", to_json(comparison, baseline, context));
  write_file_atomically(folder / "report.html", comparison_page(comparison, baseline, context, pictures));
}

}  // namespace lacuna
