#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "physics/catalogue.h"
#include "physics/course.h"
#include "physics/units.h"
#include "reports/json.h"
#include "reports/marks.h"
#include "reports/replay_section.h"
#include "reports/report.h"
#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "scenarios/files.h"
#include "scenarios/recording.h"

namespace lacuna {
namespace {

/// Bars in the chart of a round; the table lists everything.
constexpr std::size_t kMostBars = 12;

const char* tone_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent: return "good";
    case Verdict::missing_physics: return "found";
    case Verdict::unknown_physics: return "open";
  }
  return "";
}

bool is_finding(const Diagnosis& diagnosis, const Candidate& candidate) {
  return candidate.note.empty() &&
         std::any_of(diagnosis.findings.begin(), diagnosis.findings.end(),
                     [&](const Finding& f) { return f.effect == candidate.effect && f.place == candidate.place; });
}

void add_tiles(Page& page, const Diagnosis& d) {
  page.tile("Verdict",
            d.verdict == Verdict::consistent        ? "consistent"
            : d.verdict == Verdict::missing_physics ? "missing physics"
                                                    : "unknown physics",
            d.findings.empty()       ? "no effect named"
            : d.findings.size() == 1 ? "1 effect named"
                                     : fmt::format("{} effects named", d.findings.size()));
  const Role role = judged_role(d.after);
  const double before = over_noise(rms_in(d.before, role), d.noise), after = over_noise(rms_in(d.after, role), d.noise);
  if (std::isfinite(after)) {
    const bool changed = changes_the_model(d) && std::isfinite(before);
    page.tile("Residual over noise", changed ? steady(before) + " \u2192 " + steady(after) : steady(after),
              fmt::format("{} recordings, all joints", to_string(role)));
  }
  if (!d.findings.empty()) {
    long kept = 0, available = 0;
    for (const EngineGain& gain : d.engines) {
      available += gain.available;
      kept += gain.available && gain.kept > 0.9;
    }
    if (available > 0)
      page.tile("Engines that keep the gain", fmt::format("{} of {}", kept, available), "at least 90 % of it");
  }
  page.tile("Time", duration(d.seconds), fmt::format("identified on {}, seed {}", d.engine, d.seed));
}

Html lines(const std::vector<std::string>& items) {
  Html out;
  for (const std::string& item : items) out.markup += (out.markup.empty() ? "" : "<br>") + escape(item);
  return out;
}

/// What lights up in the page's plots and in the replay.
std::string marked(const Finding& f, Marks& marks) {
  std::vector<Marks::Time> times;
  for (const Finding::Interval& i : f.times) times.push_back({i.recording, i.begin, i.end});
  return marks.add(f.place, std::move(times));
}

Html findings_table(const Diagnosis& d, Marks& marks) {
  Table table({{"effect"},
               {"where"},
               {"parameters (95 % interval)"},
               {"probability", true},
               {"which of them"},
               {"p-value", true},
               {"held-out gain", true},
               {"held-out share", true}});
  for (const Finding& f : d.findings) {
    std::vector<std::string> parameters;
    std::vector<std::string> names{fmt::format("{}: {}", effect_title(f.effect), probability(f.probability))};
    for (const Estimate& parameter : f.parameters) parameters.push_back(named_value(parameter));
    for (std::size_t i = 0; i < std::min<std::size_t>(f.rivals.size(), 3); ++i) {
      const Rival& r = f.rivals[i];
      names.push_back(fmt::format("{} at {}: {}", effect_title(r.effect), place_words(r.effect, r.place),
                                  probability(r.probability)));
    }
    table.row({element("strong", text(effect_title(f.effect)), marked(f, marks)), text(place_words(f.effect, f.place)),
               lines(parameters), text(probability(class_probability(f))), lines(names), text(chance_words(f.p_value)),
               text(with_error(f.heldout_gain, f.heldout_error)), text(percent(f.heldout_share))});
  }
  return table.html();
}

std::string times_words(const Finding& f) {
  std::vector<std::string> out;
  for (const Finding::Interval& i : f.times) {
    std::string words = fmt::format("{:.2f} to {:.2f} s", i.begin, i.end);
    out.push_back(i.recording.empty() ? words : words + " of " + i.recording);
  }
  return list_of(out);
}

std::string separation_words(const Separation& s, std::size_t number) {
  return fmt::format(
      "{}: {:.3g} s of commands within the limits of the recordings; a log-likelihood of {:.3g} is to be expected "
      "against {}, one more recording like these would give {:.3g}",
      separation_file(number), s.commands.time.back(), s.evidence, effect_title(s.rival), s.recorded);
}

Html finding_card(const Finding& f, std::size_t number, Marks& marks) {
  std::vector<std::pair<std::string, Html>> entries;
  const int index = find_effect(f.effect);
  const EffectInfo* info = index < 0 ? nullptr : &effect_table()[index];
  if (info != nullptr) {
    entries.emplace_back("what it does", element("code", text(info->equation)));
    entries.emplace_back("what one sees", text(info->shows_as));
    entries.emplace_back("what mimics it", text(info->hidden_by));
  }
  if (info != nullptr) {
    for (const Estimate& parameter : f.parameters) {
      for (const ParameterInfo& p : info->parameters) {
        if (parameter.name == p.name)
          entries.emplace_back(parameter.name, text(fmt::format("{}: {}", p.meaning, with_interval(parameter))));
      }
    }
  }
  entries.emplace_back("where it shows", text(list_of(f.regions)));
  entries.emplace_back("when it acts most", text(times_words(f)));
  entries.emplace_back("recordings", text(f.recordings.empty() ? "all" : list_of(f.recordings)));
  std::vector<std::string> others;
  for (const std::string& member : f.members) {
    if (member != f.effect) others.push_back(effect_title(member));
  }
  if (!others.empty())
    entries.emplace_back("not separated from", text(list_of(others) + " (the recordings do not tell them apart)"));
  if (f.separation) entries.emplace_back("motion that would tell", text(separation_words(*f.separation, number)));
  entries.emplace_back("stability", text(fmt::format("best in {} of the resamples of the data", percent(f.stability))));
  if (info != nullptr) entries.emplace_back("source", text(info->source));
  return element("div",
                 element("h3", text(effect_title(f.effect) + ", " + place_words(f.effect, f.place)), marked(f, marks)) +
                     facts(entries),
                 "card");
}

Html misfits_table(const std::vector<Misfit>& misfits, Marks& marks) {
  if (misfits.empty()) return {};
  Table table(
      {{"recording"}, {"joint"}, {"from (s)", true}, {"to (s)", true}, {"rms / noise", true}, {"chance", true}});
  for (const Misfit& m : misfits) {
    table.row({text(m.recording), element("span", text(m.joint), marks.add(m.joint, {{m.recording, m.begin, m.end}})),
               text(fmt::format("{:.1f}", m.begin)), text(fmt::format("{:.1f}", m.end)),
               text(fmt::format("{:.2f}", m.ratio)), text(chance_words(m.p_value))});
  }
  return table.html() +
         paragraph(
             "Seconds of the recordings that were not fitted in which the residual is beyond the noise, most "
             "energy first; each chance is multiplied by the number of seconds tested.",
             "muted small");
}

Html findings_section(const Diagnosis& d, Marks& marks) {
  Html out;
  if (d.findings.empty()) {
    out += paragraph(
        "No effect of the catalogue improves the prediction of recordings that were not fitted beyond chance.");
  } else {
    out += findings_table(d, marks);
    out += paragraph(
        "The probability is that of the effect or of another that the recordings do not tell from it; which of them "
        "it is, and how likely what was tried in its place, stands beside it. Held-out gain: log-likelihood gained on "
        "the validate recordings, \u00b1 standard error. Held-out share: "
        "share of their residual energy removed. The p-value is of the gains on the train and the validate recordings "
        "together, corrected for everything that was tried.",
        "muted small");
    for (std::size_t k = 0; k < d.findings.size(); ++k) out += finding_card(d.findings[k], k + 1, marks);
  }
  if (!d.unexplained.present) return out;
  std::string open = "Unexplained: " + rest_words(d);
  if (!d.unexplained.where.empty()) open += ", at " + list_of(d.unexplained.where);
  std::vector<std::string> known = d.unexplained.regions;
  for (const NumberByRecording& number : d.unexplained.numbers) known.push_back(number_by_recording_words(number));
  return out + element("div",
                       element("h3", text("What stays unexplained")) + paragraph(open + ".") + bullets(known) +
                           misfits_table(d.unexplained.times, marks),
                       "card");
}

/// rms per joint and role, before and after; where nothing was found there is one model only.
Html residual_section(const Scenario& scenario, const Diagnosis& d) {
  const bool two = changes_the_model(d);
  std::vector<Table::Column> columns{{"joint"}, {"recordings"},  {two ? "after" : "rms", true},
                                     {"unit"},  {"noise", true}, {two ? "after / noise" : "rms / noise", true}};
  if (two) {
    columns.insert(columns.begin() + 2, {"before", true});
    columns.insert(columns.end() - 1, {"before / noise", true});
    columns.push_back({"removed", true});
  }
  Table table(columns);
  for (const auto& [joint, unused] : rms_in(d.after, judged_role(d.after))) {
    bool first = true;
    for (const auto& [role, rms] : d.after.rms) {
      if (rms.empty()) continue;
      const double before = entry_of(rms_in(d.before, role), joint), after = entry_of(rms, joint);
      const double noise = entry_of(d.noise, joint);
      std::vector<Html> cells{
          first ? element("code", text(joint)) : Html{}, text(to_string(role)), text(steady(after)),
          text(residual_unit(scenario, &d, joint)),      text(steady(noise)),   text(steady(after / noise))};
      if (two) {
        cells.insert(cells.begin() + 2, text(steady(before)));
        cells.insert(cells.end() - 1, text(steady(before / noise)));
        cells.push_back(text(percent(1.0 - after * after / (before * before))));
      }
      table.row(cells, two && role == Role::test && after < 0.5 * before);
      first = false;
    }
  }
  if (table.empty()) return {};
  std::string words = "rms of simulated minus measured. ";
  if (two)
    words +=
        "Before: the plain model, re-identified. After: the diagnosed model. Removed: share of the residual's energy. ";
  return table.html() + paragraph(words + "Test recordings served neither to fit nor to choose.", "muted small");
}

Html round_chart(const Diagnosis& d, const std::vector<Candidate>& round) {
  std::vector<const Candidate*> order;
  order.reserve(round.size());
  for (const Candidate& candidate : round) order.push_back(&candidate);
  const auto rank = [](const Candidate* c) { return std::isfinite(c->heldout_gain) ? c->heldout_gain : -HUGE_VAL; };
  std::stable_sort(order.begin(), order.end(), [&](auto* a, auto* b) { return rank(a) > rank(b); });
  BarChart chart;
  chart.title = "Held-out gain of the candidates";
  chart.description =
      "Log-likelihood gained on the validate recordings with one standard error; kept ones highlighted.";
  chart.x_label = "held-out gain, log-likelihood";
  for (std::size_t i = 0; i < std::min(order.size(), kMostBars); ++i) {
    const Candidate& c = *order[i];
    chart.bars.push_back({effect_title(c.effect) + ", " + c.place, c.heldout_gain, c.heldout_error,
                          with_error(c.heldout_gain, c.heldout_error), is_finding(d, c)});
  }
  Table table({{"effect"},
               {"where"},
               {"parameters", true},
               {"train gain", true},
               {"held-out gain", true},
               {"held-out share", true},
               {"p-value", true},
               {"outcome"}});
  for (const Candidate* c : order) {
    table.row(
        {text(effect_title(c->effect)), text(place_words(c->effect, c->place)), text(std::to_string(c->parameters)),
         text(number(c->train_gain, 4)), text(with_error(c->heldout_gain, c->heldout_error)),
         text(percent(c->heldout_share)), text(chance_words(c->p_value)), text(c->note.empty() ? "kept" : c->note)},
        is_finding(d, *c));
  }
  return to_svg(chart) + details(fmt::format("All {} candidates", order.size()), table.html());
}

Html tried_section(const Diagnosis& d) {
  Html out;
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < d.rounds.size(); ++i) {
    if (d.rounds[i].empty()) continue;
    std::string title = fmt::format("Round {}", i + 1);
    if (!kept.empty()) title += ", with " + list_of(kept) + " in the model";
    for (const Candidate& candidate : d.rounds[i])
      if (candidate.note.empty()) kept.push_back(effect_title(candidate.effect) + " at " + candidate.place);
    out += element("h3", text(title)) + round_chart(d, d.rounds[i]);
  }
  if (out.markup.empty()) return out;
  return paragraph(
             "Every effect of the catalogue at every place it may act, each re-identified together with the model's "
             "own parameters, and judged on recordings that were not fitted.") +
         out;
}

Html engine_section(const Diagnosis& d) {
  if (d.engines.empty()) return {};
  Table table({{"engine"}, {"before / noise", true}, {"after / noise", true}, {"gain kept", true}, {"remarks"}});
  bool ratios = false;
  for (const EngineGain& g : d.engines) ratios = ratios || std::isfinite(over_noise(g.after, d.noise));
  for (const EngineGain& g : d.engines) {
    const std::string remark = g.available ? (g.engine == d.engine ? "identified here" : "") : g.reason;
    const double before = over_noise(g.before, d.noise), after = over_noise(g.after, d.noise);
    table.row({text(g.engine), text(g.available ? steady(before) : ""), text(g.available ? steady(after) : ""),
               text(g.available && changes_the_model(d) ? percent(g.kept) : ""), text(remark)});
  }
  std::string words = "The same parameters and the same effects, simulated by each engine on the test recordings.";
  if (changes_the_model(d))
    words += fmt::format(" Gain kept: the share of {}'s reduction of residual energy that remains.", d.engine);
  if (!ratios) words += " The noise is not known, so ratios to it are left out.";
  return table.html() + paragraph(words, "muted small");
}

Html method_section(const Diagnosis& d) {
  std::vector<std::string> steps{
      fmt::format("The plain model's free parameters are identified on the train recordings ({}, {}).",
                  d.before.optimizer, d.before.engine),
      "Each effect of the catalogue is added at each place in turn and everything is identified again. An effect holds "
      "the "
      "plain model exactly at its neutral value, so adding it can only be judged by what it gains.",
      "What is gained is measured on the validate recordings, which were not fitted, against the spread of the gain "
      "over "
      "blocks of time and against chance, corrected for the number of effects tried. The best survivor is kept and the "
      "search repeats with it in the model.",
      "The test recordings are opened last: they are reported, never used to fit or to choose."};
  Html out;
  for (const std::string& step : steps) out += element("li", text(step));
  out = element("ol", out);
  const StepChoice& step = d.after.step;
  if (step.step > 0.0) {
    std::string words = fmt::format("Integration step at most {}", quantity(step.step * 1e3, "ms", 3));
    if (std::isfinite(step.error_over_noise))
      words += fmt::format("; measured by halving, it leaves an error of {} times the noise",
                           number(step.error_over_noise, 2));
    out += paragraph(words + ".");
  }
  return out;
}

/// Joints drawn large: those with a finding, or with something unexplained.
std::vector<std::string> leading_joints(const Diagnosis& d) {
  std::vector<std::string> out = d.unexplained.present ? d.unexplained.where : std::vector<std::string>{};
  for (const Finding& finding : d.findings) out.push_back(finding.place);
  const auto drawn = [&](const std::string& joint) {
    return std::any_of(d.traces.begin(), d.traces.end(), [&](const Trace& trace) { return trace.joint == joint; });
  };
  out.erase(std::remove_if(out.begin(), out.end(), [&](const std::string& joint) { return !drawn(joint); }), out.end());
  // Nothing to lead with on a robot of many joints: all of them small.
  if (out.empty() && d.traces.size() > 2) out.emplace_back();
  return out;
}

/// One test recording as columns: time, then measured, before and after of each joint; what `fit` gives the rms of.
Recording as_columns(const std::vector<Trace>& traces) {
  Recording out;
  out.names = {"t"};
  out.columns = {traces.front().time};
  for (const Trace& t : traces) {
    for (const auto& [name, column] :
         {std::pair("measured", &t.measured), std::pair("before", &t.before), std::pair("after", &t.after)}) {
      out.names.push_back(t.joint + "_" + name);
      out.columns.push_back(*column);
    }
  }
  return out;
}

/// The field's regression beside the diagnosed model, joint by joint.
Html idim_section(const Diagnosis& d) {
  if (!d.idim) return {};
  const Role role = judged_role(d.after);
  Table table({{"joint"},
               {"diagnosed model", true},
               {"regression", true},
               {"viscous", true},
               {"Coulomb", true},
               {"offset", true},
               {"armature", true}});
  for (const auto& [of, rms] : d.idim->rms) {
    if (of != role) continue;
    for (const auto& [joint, value] : rms) {
      const auto own = std::find_if(d.idim->joints.begin(), d.idim->joints.end(),
                                    [&, name = joint](const IdimJoint& j) { return j.joint == name; });
      if (own == d.idim->joints.end()) continue;
      table.row({element("code", text(joint)), text(steady(entry_of(rms_in(d.after, role), joint))),
                 text(steady(value)), text(number(own->viscous, 3)), text(number(own->coulomb, 3)),
                 text(number(own->offset, 3)), text(number(own->armature, 3))});
    }
  }
  return table.html() +
         paragraph(
             fmt::format("rms on the {} recordings. The regression (inverse dynamic identification model) has ten "
                         "numbers for every link, of which the recordings determine {} combinations, and viscous "
                         "and Coulomb friction, an offset and an armature at every joint; it is linear, knows no "
                         "other physics and is fitted to the same recordings.",
                         to_string(role), d.idim->rank),
             "muted small");
}

/// A chart's speeds where it was seen at all.
std::pair<std::vector<double>, std::vector<double>> seen_speeds(const ValveChart& chart) {
  constexpr double kSeen = 0.2;  // s
  std::pair<std::vector<double>, std::vector<double>> out;
  for (std::size_t k = 0; k < chart.command.size(); ++k) {
    if (chart.seen[k] < kSeen) continue;
    out.first.push_back(chart.command[k]), out.second.push_back(chart.speed[k]);
  }
  return out;
}

/// Speed against command of one joint, recorded and simulated.
Html valve_plot(const Scenario& scenario, const ValveComparison& valve, const std::string& position_unit) {
  const auto [u, recorded] = seen_speeds(valve.recorded);
  const auto [w, simulated] = seen_speeds(valve.simulated);
  LinePlot plot;
  plot.title = valve.recorded.name + ": speed against command";
  plot.description = "Recorded speeds as points, those of the final model's simulations as a line.";
  plot.x_label = "command", plot.x_unit = command_unit(scenario, valve.recorded.name);
  plot.y_label = "speed", plot.y_unit = position_unit + "/s";
  plot.curves = {{"recorded", u, recorded, Ink::measured, 1.4, false, true}, {"simulated", w, simulated, Ink::after}};
  plot.zero_line = true;
  return element("h3", element("code", text(valve.recorded.name))) + to_svg(plot);
}

/// Speed against command, and the map without any law beside the diagnosed model.
Html valve_section(const Scenario& scenario, const Diagnosis& d) {
  if (d.valves.empty()) return {};
  const Role role = judged_role(d.after);
  Table table({{"joint"}, {"diagnosed model", true}, {"map", true}, {"unit"}, {"delay (s)", true}, {"lag (s)", true}});
  Html plots;
  for (const ValveComparison& valve : d.valves) {
    const ValveChart& chart = valve.recorded;
    const std::string unit = residual_unit(scenario, &d, chart.name);
    const auto of =
        std::find_if(chart.rms.begin(), chart.rms.end(), [&](const auto& rms) { return rms.first == role; });
    table.row({element("code", text(chart.name)), text(steady(entry_of(rms_in(d.after, role), chart.name))),
               text(of == chart.rms.end() ? "" : steady(of->second)), text(unit), text(number(chart.delay, 2)),
               text(number(chart.lag, 2))});
    plots += valve_plot(scenario, valve, unit);
  }
  return table.html() +
         paragraph(fmt::format("rms on the {} recordings. The map is a free curve of speed over command with one delay "
                               "and one lag, fitted to the train recordings of each joint alone: it knows no law, no "
                               "load and no other joint. A model that predicts worse has its valve wrong.",
                               to_string(role)),
                   "muted small") +
         plots;
}

Html before_after_section(const Diagnosis& d) {
  TraceOptions options;
  options.leading = leading_joints(d);
  options.noise = d.noise;
  options.findings = d.findings;
  if (!changes_the_model(d)) options.words = {"", "identified model"};
  const auto shown = [&](std::vector<Trace> traces) {
    if (!changes_the_model(d)) {
      for (Trace& trace : traces) trace.before.clear();
    }
    return trace_section(traces, options);
  };
  Html out = shown(d.traces);
  for (std::size_t k = 1; k < d.replays.size(); ++k) {
    const Replay& replay = d.replays[k];
    out += details(fmt::format("{} ({} recording)", replay.recording, to_string(replay.role)), shown(replay.traces));
  }
  return out;
}

Html replay_of(const Scenario& scenario, const Diagnosis& d) {
  if (changes_the_model(d)) return replay_section(scenario, d.replays, {"plain model", "diagnosed model"});
  std::vector<Replay> replays = d.replays;
  for (Replay& replay : replays) {
    for (Trace& trace : replay.traces) trace.after.clear();
    for (Replay::Effort& effort : replay.missing) effort.after.clear();
  }
  return replay_section(scenario, replays, {"identified model", ""});
}

}  // namespace

std::string diagnosis_page(const Scenario& scenario, const Diagnosis& d, const Context& context,
                           std::span<const Picture> pictures) {
  Page page(d.scenario, "Lacuna diagnosis");
  std::vector<std::string> prefixes;
  for (const Finding& finding : d.findings) prefixes.push_back(finding.place + "." + finding.effect + ".");
  page.lead(verdict_sentence(scenario, d), tone_of(d.verdict));
  add_tiles(page, d);
  Marks marks;
  const Html findings = findings_section(d, marks), events = events_section(d.events, marks);
  page.section("Findings", findings + marks.data());
  page.section("Learned where the catalogue has no name", learned_section(d.learned));
  page.section("Events in the recordings", events);
  page.section("Replay", replay_of(scenario, d));
  page.section(changes_the_model(d) ? "Before and after" : "Measured and simulated", before_after_section(d));
  page.section("Where the plain model fails", missing_effort_section(d.missing));
  page.section("The chain from command to motion", chain_section(d.chain, changes_the_model(d)));
  page.section("Pictures", picture_section(pictures));
  page.section("Residuals", residual_section(scenario, d));
  page.section("Beside the base-parameter regression", idim_section(d));
  page.section("Speed against command", valve_section(scenario, d));
  page.section("Whiteness of the residuals", whiteness_section(d.whiteness, leading_joints(d), changes_the_model(d)));
  page.section("What was tried", tried_section(d));
  page.section("Parameters", parameter_section(d.after.estimates, prefixes));
  page.section("The found model fitted to every recording, test included (for comparison with other references only)",
               parameter_section(d.all_recordings, prefixes));
  page.section("What the data determine", identifiability_section(d.after));
  page.section("Engines", engine_section(d));
  page.section("Population search", convergence_section(d.after.history.size() > 1 ? d.after : d.before));
  page.section("Notes", bullets(d.notes));
  page.section("Method", method_section(d));
  page.section("Context", context_section(context));
  return page.str();
}

std::vector<std::string> write_diagnosis_report(const std::filesystem::path& folder, const Scenario& scenario,
                                                const Diagnosis& diagnosis, const Context& context,
                                                std::span<const Picture> pictures) {
  std::vector<std::string> written{"report.html", "diagnosis.json"};
  for (std::size_t k = 0; k < diagnosis.findings.size(); ++k) {
    const auto& separation = diagnosis.findings[k].separation;
    if (!separation) continue;
    written.push_back(separation_file(k + 1));
    write_csv(folder / written.back(), as_recording(scenario, separation->commands));
  }
  for (std::size_t k = 0; k < diagnosis.predictions.size(); ++k) {
    written.push_back(prediction_file(k + 1));
    write_csv(folder / written.back(), as_columns(diagnosis.predictions[k]));
  }
  write_file_atomically(folder / "diagnosis.json", to_json(diagnosis, context));
  write_file_atomically(folder / "report.html", diagnosis_page(scenario, diagnosis, context, pictures));
  return written;
}

}  // namespace lacuna
