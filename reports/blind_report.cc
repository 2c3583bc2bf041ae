// `blind.json` and the page beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "physics/catalogue.h"
#include "reports/blind.h"
#include "reports/json.h"
#include "reports/json_text.h"
#include "reports/sections.h"
#include "reports/svg.h"
#include "reports/wording.h"
#include "reports/zoomable.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const Rate& rate) {
  const auto [low, high] = rate.ci95();
  return {{"hits", rate.hits}, {"of", rate.of}, {"share", number_or_null(rate.share())}, {"ci95", {low, high}}};
}

Json json_of(const BlindLabel& label) {
  Json effects = Json::array();
  for (const BlindLabel::Effect& hidden : label.effects)
    effects.push_back(
        {{"effect", hidden.effect}, {"location", hidden.place}, {"strength", number_or_null(hidden.strength)}});
  Json conditions = Json::object();
  for (const auto& [name, much] : label.conditions) conditions[name] = number_or_null(much);
  return {{"effects", effects},
          {"conditions", conditions},
          {"left_rms_over_noise", number_or_null(label.left_rms_over_noise)}};
}

Json json_of(const BlindLabel::Effect& hidden, const LawScore& law) {
  const bool described = hidden.law.has_value();
  return {{"effect", hidden.effect},
          {"location", hidden.place},
          {"place_right", law.place},
          {"stage_right", described ? Json(law.stage) : Json(nullptr)},
          {"over_right", described ? Json(law.over) : Json(nullptr)},
          {"curve_error", number_or_null(law.curve_error)},
          {"events", law.events},
          {"events_found", law.found}};
}

/// What was learned, held against what was hidden outside the catalogue.
Json laws_of(const BlindCase& one, const CaseScore& score) {
  Json out = Json::array();
  for (const BlindLabel::Effect& hidden : one.label->effects)
    if (find_effect(hidden.effect) < 0) out.push_back(json_of(hidden, score.laws[out.size()]));
  return out;
}

Json json_of(const BlindCase& one) {
  Json out{{"case", one.name}, {"seal", to_string(one.seal)}};
  out["label"] = one.label ? json_of(*one.label) : Json(nullptr);
  out["verdict"] = one.verdict ? Json(one.verdict->verdict) : Json(nullptr);
  if (!one.error.empty()) out["error"] = one.error;
  out["findings"] = Json::array();
  if (one.verdict) {
    for (const BlindVerdict::Claim& claim : one.verdict->claims)
      out["findings"].push_back({{"effect", claim.effect},
                                 {"where", claim.place},
                                 {"probability", number_or_null(claim.probability)},
                                 {"class", claim.members}});
  }
  out["learned"] = one.verdict ? one.verdict->learned.size() : 0;
  out["correct"] = nullptr;
  if (one.label && one.seal != Seal::broken) {
    const CaseScore score = score_case(one);
    for (std::size_t c = 0; c < score.claim_true.size(); ++c) out["findings"][c]["true"] = bool(score.claim_true[c]);
    out["kind"] = to_string(score.kind);
    out["correct"] = score.correct;
    out["location_right"] = score.location;
    out["effect_right"] = score.effect;
    out["class_right"] = score.in_class;
    out["f1"] = score.f1;
    out["heldout_gain_share"] = number_or_null(score.gain_share);
    out["rest_over_noise"] = number_or_null(score.rest_over_noise);
    out["outside"] = laws_of(one, score);
  }
  out["seconds"] = one.verdict ? number_or_null(one.verdict->seconds) : Json(nullptr);
  return out;
}

Json bins_of(const BlindTotals& totals) {
  Json out = Json::array();
  for (const CalibrationBin& bin : totals.calibration)
    out.push_back({{"from", bin.from},
                   {"to", std::min(bin.to, 1.0)},
                   {"claims", bin.truth.of},
                   {"true", bin.truth.hits},
                   {"mean_probability", number_or_null(bin.probability_sum / bin.truth.of)},
                   {"true_share", number_or_null(bin.truth.share())}});
  return out;
}

Json strength_of(const BlindTotals& totals) {
  Json out = Json::array();
  for (const StrengthBin& bin : totals.strength)
    out.push_back({{"left_rms_over_noise_from", bin.from},
                   {"left_rms_over_noise_to", bin.to < 1e299 ? Json(bin.to) : Json(nullptr)},
                   {"location", json_of(bin.location)},
                   {"class", json_of(bin.in_class)}});
  return out;
}

Json json_of(const Baselines& baselines) {
  return {{"parameters_only_refit", {{"heldout_gain_share", baselines.refit_gain_share}}},
          {"largest_residual_joint", {{"location_top1", json_of(baselines.largest_residual_location)}}},
          {"plain_bic",
           {{"null_false_alarms", json_of(baselines.bic_false_alarms)},
            {"location_top1", json_of(baselines.bic_location)},
            {"effect_top1", json_of(baselines.bic_effect)}}}};
}

Json json_of(const LawTotals& t) {
  return {{"unknown", json_of(t.unknown)},
          {"place", json_of(t.place)},
          {"stage", json_of(t.stage)},
          {"over", json_of(t.over)},
          {"curve_error", number_or_null(t.median_error())},
          {"curves", t.curves},
          {"curves_learned", t.curve_errors.size()},
          {"events", json_of(t.events)},
          {"at_noise", json_of(t.at_noise)}};
}

/// All together, then by hidden effect.
Json outside_of(const BlindTotals& t) {
  Json out = json_of(t.laws);
  out["events_true"] = json_of(t.events_true);
  out["false_laws"] = {{"null", json_of(t.false_laws_null)}, {"exact", json_of(t.false_laws_exact)}};
  out["by_effect"] = Json::object();
  for (const auto& [effect, laws] : t.laws_of) out["by_effect"][effect] = json_of(laws);
  return out;
}

/// Plain numbers under the names that others look for, what they rest on beside them.
Json json_of(const BlindTotals& t) {
  return {{"cases", t.cases},
          {"labelled", t.labelled},
          {"failed", t.failed},
          {"correct", t.correct.hits},
          {"null_false_alarms", t.null_false_alarms.hits},
          {"location_top1", number_or_null(t.location_top1.share())},
          {"effect_top1", number_or_null(t.effect_top1.share())},
          {"class_top1", number_or_null(t.class_top1.share())},
          {"abstained_correctly", number_or_null(t.abstained_correctly.share())},
          {"set_f1", number_or_null(t.set_f1)},
          {"heldout_gain_share", number_or_null(t.heldout_gain_share)},
          {"calibration", bins_of(t)},
          {"claims_above_09", json_of(t.claims_above_09)},
          {"outside", outside_of(t)},
          {"seconds", t.seconds},
          {"longest_seconds", t.longest},
          {"rates",
           {{"correct", json_of(t.correct)},
            {"null_false_alarms", json_of(t.null_false_alarms)},
            {"location_top1", json_of(t.location_top1)},
            {"effect_top1", json_of(t.effect_top1)},
            {"class_top1", json_of(t.class_top1)},
            {"abstained_correctly", json_of(t.abstained_correctly)},
            {"set_f1_cases", t.several},
            {"heldout_gain_share_cases", t.shared}}}};
}

std::string out_of(const Rate& rate) { return fmt::format("{} of {}", rate.hits, rate.of); }

std::string with_ci(const Rate& rate) {
  if (rate.of == 0) return "\u2013";
  const auto [low, high] = rate.ci95();
  return fmt::format("{} ({} to {})", percent(rate.share()), percent(low), percent(high));
}

Html totals_section(const BlindTotals& t) {
  Table table({{"question"}, {"asked", true}, {"yes", true}, {"share (95 % interval)", true}});
  const auto row = [&](const char* words, const Rate& rate) {
    if (rate.of == 0) return;
    table.row({text(words), text(std::to_string(rate.of)), text(std::to_string(rate.hits)), text(with_ci(rate))});
  };
  row("the whole verdict: right", t.correct);
  row("nothing hidden, yet something said (false alarms)", t.null_false_alarms);
  row("one effect hidden: its place right", t.location_top1);
  row("one effect hidden: itself named", t.effect_top1);
  row("one effect hidden: its class named", t.class_top1);
  row("outside the catalogue: called unknown", t.abstained_correctly);
  row("claims of a probability above 0.9: true", t.claims_above_09);
  Html out = table.html();
  if (t.several > 0)
    out += paragraph(
        fmt::format("Several effects at once: mean F1 of the set {} over {} cases.", number(t.set_f1, 3), t.several));
  if (t.shared > 0)
    out += paragraph(
        fmt::format("Of the gain on held-out recordings that an oracle would have, which leaves the noise alone: {} "
                    "(mean over {} cases).",
                    percent(t.heldout_gain_share), t.shared));
  return out + paragraph("Intervals: Clopper and Pearson.", "muted small");
}

void law_row(const std::string& name, const LawTotals& t, bool emphasised, Table& table) {
  const auto share = [](const Rate& rate) { return text(rate.of > 0 ? out_of(rate) : "\u2013"); };
  const std::string learned =
      fmt::format("{} ({} of {})", number(t.median_error(), 2), t.curve_errors.size(), t.curves);
  table.row({element("code", text(name)), share(t.unknown), share(t.place), share(t.stage), share(t.over),
             text(t.curve_errors.empty() ? "\u2013" : learned), share(t.events), share(t.at_noise)},
            emphasised);
}

Html outside_section(const BlindTotals& t) {
  if (t.laws_of.empty() && t.false_laws_null.hits + t.false_laws_exact.hits == 0) return {};
  Html out;
  Table table({{"hidden"},
               {"called unknown", true},
               {"joint", true},
               {"stage", true},
               {"variables", true},
               {"curve's error", true},
               {"events found", true},
               {"rest at the noise", true}});
  for (const auto& [effect, laws] : t.laws_of) law_row(effect, laws, false, table);
  if (t.laws_of.size() > 1) law_row("all", t.laws, true, table);
  if (!table.empty())
    out +=
        table.html() +
        paragraph(fmt::format("Stage and variables count together with what stands before them. Curve's error: "
                              "median rms off the hidden curve over that curve's own, constant and linear parts left "
                              "out. Events: both ends within {} s. Rest at the noise: at most {} of it on held-out "
                              "recordings.",
                              number(kEventEdge), number(kAtNoise)),
                  "muted small");
  if (t.events_true.of > 0) out += paragraph(fmt::format("Events learned that are true: {}.", out_of(t.events_true)));
  return out + paragraph(fmt::format("Laws or events learned where nothing was hidden: {}; where effects of the "
                                     "catalogue alone were: {}.",
                                     out_of(t.false_laws_null), out_of(t.false_laws_exact)));
}

/// What should have been said of a case.
std::string right_word(const std::string& hidden) {
  if (hidden == "nothing") return "consistent";
  return find_effect(hidden) < 0 ? "unknown_physics" : hidden;
}

/// A label's condition in words.
std::string condition_words(const std::string& name) {
  static const std::map<std::string, std::string> kWords{
      {"background", "a ripple and a slow push at every joint that no effect describes"},
      {"uneven", "laws whose strength changes along their way"},
      {"drift", "laws whose strength differs between recordings"},
      {"misplaced", "centres of mass that the URDF has wrong"},
      {"seconds", "short recordings"},
      {"alone", "one joint alone commanded"},
      {"everywhere", "one effect at several joints"},
      {"none", "none of these"}};
  const auto at = kWords.find(name);
  return at == kWords.end() ? name : at->second;
}

Html condition_section(const std::vector<std::pair<std::string, BlindTotals>>& by_condition) {
  if (by_condition.empty()) return {};
  Table table({{"condition"},
               {"cases", true},
               {"right", true},
               {"false alarms where nothing was hidden", true},
               {"place", true},
               {"class", true},
               {"mean F1 of several", true},
               {"claims above 0.9 that are true", true}});
  const auto share = [](const Rate& rate) { return text(rate.of > 0 ? out_of(rate) : "\u2013"); };
  for (const auto& [name, t] : by_condition)
    table.row({text(condition_words(name)), text(std::to_string(t.cases)), share(t.correct), share(t.null_false_alarms),
               share(t.location_top1), share(t.class_top1), text(t.several > 0 ? number(t.set_f1, 3) : "\u2013"),
               share(t.claims_above_09)});
  return table.html() + paragraph(
                            "A case may stand under several conditions. Where a machine is unlike any model, what is "
                            "claimed must be true and what was hidden must be claimed; that something unknown is left "
                            "may be said, too.",
                            "muted small");
}

Html confusion_section(const BlindTotals& t) {
  if (t.confusion.empty()) return {};
  std::set<std::string> said;
  for (const auto& [hidden, row] : t.confusion)
    for (const auto& [word, count] : row) said.insert(word);
  std::vector<Table::Column> columns{{"hidden"}};
  for (const std::string& word : said) columns.push_back({word, true});
  Table table(columns);
  for (const auto& [hidden, row] : t.confusion) {
    std::vector<Html> cells{element("code", text(hidden))};
    for (const std::string& word : said) {
      const auto at = row.find(word);
      const std::string count = at == row.end() ? "" : std::to_string(at->second);
      cells.push_back(word == right_word(hidden) ? element("strong", text(count)) : text(count));
    }
    table.row(cells);
  }
  return table.html() +
         paragraph(
             "First finding of each case, or the verdict where nothing was named; cases of several effects are "
             "left out.",
             "muted small");
}

Html calibration_section(const BlindTotals& t) {
  std::vector<double> claimed, truth;
  Table table({{"probability"}, {"claims", true}, {"mean", true}, {"true", true}, {"share (95 % interval)", true}});
  for (const CalibrationBin& bin : t.calibration) {
    if (bin.truth.of == 0) continue;
    claimed.push_back(bin.probability_sum / bin.truth.of);
    truth.push_back(bin.truth.share());
    table.row({text(fmt::format("{} to {}", number(bin.from), number(std::min(bin.to, 1.0)))),
               text(std::to_string(bin.truth.of)), text(number(claimed.back(), 3)),
               text(std::to_string(bin.truth.hits)), text(with_ci(bin.truth))});
  }
  if (table.empty()) return {};
  const std::vector<double> ends{0.0, 1.0};
  LinePlot plot;
  plot.title = "Calibration";
  plot.description = "Share of claims that are true against the probability claimed; the diagonal is honest.";
  plot.x_label = "probability claimed";
  plot.y_label = "share true";
  plot.x_range = std::pair(0.0, 1.0);
  plot.curves = {{"honest", ends, ends, Ink::other, 1.2, true}, {"claims", claimed, truth, Ink::after, 2.0, false}};
  return zoomable(plot) + table.html();
}

Html strength_section(const BlindTotals& t) {
  Table table(
      {{"left rms over noise"}, {"cases", true}, {"place (95 % interval)", true}, {"class (95 % interval)", true}});
  BarChart chart;
  chart.title = "Accuracy against strength";
  chart.description = "Share of single effects whose class and place were named, by what a plain refit leaves.";
  chart.x_label = "class right, share";
  for (const StrengthBin& bin : t.strength) {
    if (bin.location.of == 0) continue;
    const std::string range =
        bin.to < 1e299 ? fmt::format("{} to {}", number(bin.from), number(bin.to)) : "above " + number(bin.from);
    table.row(
        {text(range), text(std::to_string(bin.location.of)), text(with_ci(bin.location)), text(with_ci(bin.in_class))});
    chart.bars.push_back({range, bin.in_class.share(), 0.0, out_of(bin.in_class), false});
  }
  return table.empty() ? Html{} : to_svg(chart) + table.html();
}

Html baseline_section(const BlindTotals& t) {
  if (t.labelled == 0) return {};
  const Baselines& b = t.baselines;
  Table table({{"method"}, {"false alarms", true}, {"place", true}, {"effect", true}, {"share of the gain", true}});
  table.row({text("this diagnosis"), text(with_ci(t.null_false_alarms)), text(with_ci(t.location_top1)),
             text(with_ci(t.effect_top1)), text(percent(t.heldout_gain_share))},
            true);
  table.row({text("parameters refitted, nothing else"), text("0 %"), text("\u2013"), text("\u2013"),
             text(percent(b.refit_gain_share))});
  table.row({text("joint of the largest residual over noise"), text("\u2013"),
             text(with_ci(b.largest_residual_location)), text("\u2013"), text("\u2013")});
  table.row({text("best Schwarz criterion on train, first round"), text(with_ci(b.bic_false_alarms)),
             text(with_ci(b.bic_location)), text(with_ci(b.bic_effect)), text("\u2013")});
  return table.html() +
         paragraph(
             "The largest residual is asked for effects at joints only. The share of the gain is counted from the "
             "refitted plain model.",
             "muted small");
}

std::string hidden_words(const BlindCase& one) {
  if (!one.label) return "no label";
  if (one.seal == Seal::broken) return "the label does not match its seal";
  std::vector<std::string> words;
  for (const BlindLabel::Effect& hidden : one.label->effects)
    words.push_back(fmt::format("{} at {} ({})", hidden.effect, hidden.place, number(hidden.strength, 3)));
  return words.empty() ? "nothing" : list_of(words);
}

std::string said_words(const BlindCase& one) {
  if (!one.verdict) return one.error.empty() ? "no verdict" : one.error;
  std::vector<std::string> words;
  for (const BlindVerdict::Claim& claim : one.verdict->claims)
    words.push_back(fmt::format("{} at {} ({})", claim.effect, claim.place, probability(claim.probability)));
  return one.verdict->verdict + (words.empty() ? "" : ": " + list_of(words));
}

Html case_section(const std::vector<BlindCase>& cases) {
  Table table(
      {{"case"}, {"hidden"}, {"left / noise", true}, {"said"}, {"right"}, {"share of the gain", true}, {"time", true}});
  for (const BlindCase& one : cases) {
    const bool scored = one.label && one.seal != Seal::broken;
    const CaseScore score = scored ? score_case(one) : CaseScore{};
    table.row({element("code", text(one.name)), text(hidden_words(one)),
               text(scored ? number(one.label->left_rms_over_noise, 3) : ""), text(said_words(one)),
               !scored
                   ? Html{}
                   : element("span", text(score.correct ? "right" : "wrong"), score.correct ? "tag fine" : "tag warn"),
               text(scored && std::isfinite(score.gain_share) ? percent(score.gain_share) : ""),
               text(one.verdict ? duration(one.verdict->seconds) : "")});
  }
  return table.html();
}

std::string lead_sentence(const BlindTotals& t) {
  if (t.labelled == 0) return fmt::format("{} cases diagnosed; none has a label to be scored by.", t.cases);
  return fmt::format("{} verdicts right; {} false alarms where nothing was hidden.", out_of(t.correct),
                     out_of(t.null_false_alarms));
}

}  // namespace

std::string to_json(const std::vector<BlindCase>& cases, const Context& context) {
  const BlindTotals totals = total(cases);
  Json records = Json::array(), confusion = Json::object(), conditions = Json::object();
  for (const auto& [name, under] : totals_by_condition(cases)) conditions[name] = json_of(under);
  for (const BlindCase& one : cases) records.push_back(json_of(one));
  for (const auto& [hidden, row] : totals.confusion)
    for (const auto& [word, count] : row) confusion[hidden][word] = count;
  const Json out{{"format", "lacuna-blind/1"}, {"seed", context.seed},
                 {"version", context.version}, {"totals", json_of(totals)},
                 {"by_condition", conditions}, {"accuracy_by_strength", strength_of(totals)},
                 {"confusion", confusion},     {"baselines", json_of(totals.baselines)},
                 {"cases", records},           {"context", Json::parse(to_json(context))}};
  return json_text(out);
}

std::string blind_page(const std::vector<BlindCase>& cases, const std::string& folder, const Context& context) {
  const BlindTotals t = total(cases);
  Page page(folder, "Lacuna blind test");
  page.lead(lead_sentence(t), t.labelled > 0 && t.correct.hits == t.correct.of ? "good" : "found");
  page.tile("Cases", std::to_string(t.cases), fmt::format("{} with a label, {} failed", t.labelled, t.failed));
  if (t.location_top1.of > 0) page.tile("Place right", percent(t.location_top1.share()), out_of(t.location_top1));
  if (t.class_top1.of > 0) page.tile("Class right", percent(t.class_top1.share()), out_of(t.class_top1));
  page.tile("Time", duration(t.seconds), "longest case " + duration(t.longest));
  page.section("Totals", totals_section(t));
  page.section("Conditions", condition_section(totals_by_condition(cases)));
  page.section("Outside the catalogue", outside_section(t));
  page.section("Confusion", confusion_section(t));
  page.section("Calibration", calibration_section(t));
  page.section("Accuracy against strength", strength_section(t));
  page.section("Baselines", baseline_section(t));
  page.section("Cases", case_section(cases));
  page.section("Context", context_section(context));
  return page.str();
}

}  // namespace lacuna
