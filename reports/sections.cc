#include "reports/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

Html tag(std::string_view word, std::string_view tone) {
  return element("span", text(word), fmt::format("tag {}", tone));
}

/// Lowest and highest finite value.
std::pair<double, double> range_of(std::span<const double> values) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return {low, high};
}

std::vector<double> difference(std::span<const double> a, std::span<const double> b) {
  std::vector<double> out(std::min(a.size(), b.size()));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] - b[i];
  return out;
}

double rms_of(std::span<const double> values) {
  double sum = 0.0;
  std::size_t n = 0;
  for (const double value : values) {
    if (std::isfinite(value)) sum += value * value, ++n;
  }
  return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : std::nan("");
}

std::vector<std::pair<double, double>> marked_times(const Trace& trace, const std::vector<Finding>& findings) {
  std::vector<std::pair<double, double>> out;
  for (const Finding& finding : findings) {
    if (!of_whole_arm(finding.effect) && finding.place != trace.joint) continue;
    for (const Finding::Interval& i : finding.times) {
      if (i.recording.empty() || i.recording == trace.recording) out.emplace_back(i.begin, i.end);
    }
  }
  return out;
}

/// The upper plot: what was measured and what the models say.
LinePlot signal_plot(const Trace& trace, const TraceOptions& options, int width) {
  LinePlot plot;
  plot.title = fmt::format("{}, {}: measured and simulated", trace.joint, trace.recording);
  plot.description = "The measured signal over time with the simulations laid over it.";
  plot.recording = trace.recording;
  plot.joint = trace.joint;
  plot.y_label = trace.joint;
  plot.y_unit = trace.unit;
  plot.width = width;
  plot.height = 230;
  plot.x_axis_labels = false;
  if (!trace.before.empty()) plot.curves.push_back({options.words.before, trace.time, trace.before, Ink::before, 1.4});
  plot.curves.push_back({"measured", trace.time, trace.measured, Ink::measured, 1.7});
  if (!trace.after.empty())
    plot.curves.push_back({options.words.after, trace.time, trace.after, Ink::after, 1.4, true});
  plot.x_range = range_of(trace.time);
  // A simulation that runs away must not press the measurement flat.
  const auto [low, high] = range_of(trace.measured);
  const double span = high - low;
  if (span > 0.0) plot.y_limit = {low - span, high + span};
  plot.shaded = marked_times(trace, options.findings);
  return plot;
}

/// The lower one: what they leave.
LinePlot residual_plot(const Trace& trace, const TraceOptions& options, int width, std::span<const double> before,
                       std::span<const double> after) {
  LinePlot plot;
  plot.title = fmt::format("{}, {}: residual", trace.joint, trace.recording);
  plot.description =
      fmt::format("Simulated minus measured; rms {} {}, {} {}.", options.words.before,
                  quantity(rms_of(before), trace.unit, 3), options.words.after, quantity(rms_of(after), trace.unit, 3));
  plot.recording = trace.recording;
  plot.joint = trace.joint;
  plot.x_label = "time";
  plot.x_unit = "s";
  plot.y_label = "residual";
  plot.y_unit = trace.unit;
  plot.width = width;
  plot.height = 190;
  plot.zero_line = true;
  const auto label = [&](const std::string& word, std::span<const double> r) {
    return word + ", rms " + steady(rms_of(r)) + " " + trace.unit;
  };
  if (!before.empty())
    plot.curves.push_back({label(options.words.before, before), trace.time, before, Ink::before, 1.2});
  if (!after.empty()) plot.curves.push_back({label(options.words.after, after), trace.time, after, Ink::after, 1.2});
  const double noise = entry_of(options.noise, trace.joint);
  if (noise > 0.0 && std::isfinite(noise)) {
    plot.band = {-noise, noise};
    plot.band_label = "\u00b1 noise";
  }
  plot.x_range = range_of(trace.time);
  const auto [low, high] = range_of(trace.measured);
  if (high > low) plot.y_limit = {-2.0 * (high - low), 2.0 * (high - low)};
  plot.shaded = marked_times(trace, options.findings);
  plot.shaded_label = "where it acts most";
  return plot;
}

Html trace_figure(const Trace& trace, const TraceOptions& options, int width) {
  const std::vector<double> before = difference(trace.before, trace.measured);
  const std::vector<double> after = difference(trace.after, trace.measured);
  const Html title = element("h3", text(trace.joint + (trace.recording.empty() ? "" : " \u00b7 " + trace.recording)));
  return element("figure", title + zoomable(signal_plot(trace, options, width)) +
                               zoomable(residual_plot(trace, options, width, before, after)));
}

}  // namespace

Html parameter_section(const std::vector<Estimate>& estimates, const std::vector<std::string>& emphasised) {
  if (estimates.empty()) return {};
  Table table({{"parameter"}, {"value", true}, {"95 % interval", true}, {"unit"}, {"remarks"}});
  for (const Estimate& e : estimates) {
    Html remarks;
    if (!e.identifiable && !e.spans_range) remarks += tag("not determined by the data", "warn");
    if (e.at_bound) remarks += tag("at its bound", "warn");
    if (e.derived) remarks += tag("from the total mass", "");
    const bool stands_out = std::any_of(emphasised.begin(), emphasised.end(),
                                        [&](const std::string& prefix) { return e.name.starts_with(prefix); });
    table.row({element("code", text(e.name)), text(value_of(e)), text(e.spans_range ? "" : interval(e)), text(e.unit),
               remarks},
              stands_out);
  }
  return table.html();
}

Html identifiability_section(const FitResult& fit) {
  if (fit.estimates.empty()) return {};
  const std::size_t axes = fit.point.empty() ? fit.estimates.size() : fit.point.size();
  const Identifiability& known = fit.identifiability;
  Html out = paragraph(fmt::format(
      "The train recordings determine {} of {} directions of the parameter space; the condition number of the "
      "sensitivities is {}. Successive samples repeat each other: the residual is worth about {} independent samples, "
      "and the intervals are widened accordingly.",
      known.rank, axes, number(known.condition, 2), number(fit.effective_samples, 3)));
  std::vector<std::string> combinations;
  for (std::size_t i = 0; i < fit.undetermined.size(); ++i) {
    std::string words = fit.undetermined[i];
    if (i < known.undetermined.size())
      words += fmt::format(" (standard error {} of its size)", percent(known.undetermined[i].relative_error));
    combinations.push_back(words);
  }
  if (!combinations.empty()) {
    out += paragraph(
        "The data cannot tell these combinations apart (each parameter in units of its own size); "
        "moving along one of them hardly changes the prediction:");
    out += bullets(combinations);
  }
  std::vector<std::string> bound;
  for (const Estimate& e : fit.estimates) {
    if (e.at_bound) bound.push_back(e.name);
  }
  if (!bound.empty())
    out += paragraph("At a bound: " + list_of(bound) +
                     ". The true value may lie beyond; widen the bound or question the model.");
  return out;
}

Html convergence_section(const FitResult& fit) {
  if (fit.history.size() < 2) return {};
  std::vector<double> generation, best, median;
  for (std::size_t i = 0; i < fit.history.size(); ++i) {
    generation.push_back(static_cast<double>(i));
    best.push_back(fit.history[i].best);
    median.push_back(fit.history[i].median);
  }
  LinePlot plot;
  plot.title = "Convergence of the population search";
  plot.description = "Cost of the best and of the median individual by generation, logarithmic.";
  plot.x_label = "generation";
  plot.y_label = "cost";
  plot.log_y = true;
  plot.height = 260;
  plot.curves = {{"median of the generation", generation, median, Ink::other, 1.2},
                 {"best so far", generation, best, Ink::after, 2.0}};
  const GenerationRecord& last = fit.history.back();
  return zoomable(plot) +
         paragraph(fmt::format("{} generations, {} simulations in all; best cost {} after the population search.",
                               fit.history.size(), fit.evaluations, number(last.best, 4)),
                   "muted small");
}

Html trace_section(std::span<const Trace> traces, const TraceOptions& options) {
  const auto leads = [&](const Trace& trace) {
    return options.leading.empty() ||
           std::find(options.leading.begin(), options.leading.end(), trace.joint) != options.leading.end();
  };
  Html first, rest;
  for (const Trace& trace : traces) {
    if (leads(trace))
      first += trace_figure(trace, options, 960);
    else
      rest += trace_figure(trace, options, 500);
  }
  if (!rest.markup.empty()) rest = element("div", rest, "pair");
  return first + rest;
}

Html picture_section(std::span<const Picture> pictures) {
  Html out;
  for (const Picture& p : pictures) {
    if (p.png.empty()) continue;
    out += element("figure", picture(p.png, p.title) + element("figcaption", text(p.title)));
  }
  return out.markup.empty() ? out : element("div", out, "gallery");
}

Html facts(const std::vector<std::pair<std::string, Html>>& entries) {
  Html out;
  for (const auto& [term, body] : entries) {
    if (!body.markup.empty()) out += element("dt", text(term)) + element("dd", body);
  }
  return element("dl", out, "facts");
}

Html context_section(const Context& c) {
  std::vector<std::string> engine_versions;
  for (const auto& [engine, version_text] : c.engine_versions)
    engine_versions.push_back(version_text.empty() ? engine : fmt::format("{} {}", engine, version_text));
  return facts({{"command", element("code", text(c.command_line))},
                {"date", text(c.date)},
                {"lacuna", text(fmt::format("{} (commit {})", c.version, c.commit))},
                {"seed, threads, ranks", text(fmt::format("{}, {}, {}", c.seed, c.threads, c.ranks))},
                {"machine", text(fmt::format("{}, {}, {} hardware threads", c.host, c.cpu, c.cores))},
                {"lanes", text(c.lanes)},
                {"engines", text(list_of(engine_versions))},
                {"compiler", text(fmt::format("{}, {}", c.compiler, c.build_type))},
                {"flags", element("code", text(c.flags))}});
}

}  // namespace lacuna
